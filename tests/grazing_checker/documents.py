"""Certificates of the oscillator, one of every kind, and ways to change them."""

from copy import deepcopy
from functools import cache

import grazing as gz
from grazing.proof.certify import certify
from grazing.proof.enclose import enclose
from grazing_checker.check import KINDS, trusted_base
from grazing_checker.envelope import seal
from grazing_checker.sentence import orbit_sentence, value_sentence
from tests.models import cubic
from tests.proof.orbits import attractor, doubled, without_impacts

NAMES = ("stable", "unstable", "free", "own", "pd", "gr", "lp", "ns")
SENTENCES = {"periodic orbit": orbit_sentence, "bifurcation value": value_sentence}
#: Numbers that only help to prove: not unique, and not part of the statement.
WITNESSES = {("data", "preconditioner"), ("data", "ends")}


def own_model():
    return gz.Oscillator(
        alpha=1.5, k=1.2, forcing=gz.Forcing(omega=2.2, offset=0.05), sigma=0.02, reset=gz.reset(cubic, e=0.8, c=0.5)
    )


@cache
def documents():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    (fold,) = (o for o in gz.one_impact_orbits(gz.pinball(alpha=0.2, omega=2.8, V=0.0, d=0.55), 2) if o.stable)
    (ns,) = gz.one_impact_orbits(gz.pinball(alpha=0.05, d=0.1), 1)
    found = {
        "stable": certify(orbit),
        "unstable": certify(doubled(gz.pinball(d=0.12, V=0.4), 3, "d", 0.12328144964392065, 0.11)),
        "free": certify(without_impacts(gz.pinball(d=0.14))),
        "own": certify(attractor(own_model(), (0.2, 0.1), 1)),
        "pd": enclose(orbit, "pd", "V"),
        "gr": enclose(orbit, "gr", "d"),
        "lp": enclose(fold, "lp", "d"),
        "ns": enclose(ns, "ns", "r"),
    }
    assert tuple(found) == NAMES
    return {name: certificate.document for name, certificate in found.items()}


def resealed(document):
    return seal(*(document[name] for name in ("kind", "statement", "trusted_base", "data", "inequalities")))


def claiming(document):
    """The same with the sentence that its data make, sealed again; what a forger would do."""
    said = SENTENCES[document["kind"]](document["data"])
    return resealed({**document, "statement": said, "trusted_base": trusted_base(document["kind"])})


def leaves(value, path=()):
    """Every path to something that is no list and no mapping, and to every empty one."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    if not value or not isinstance(value, (dict, list)):
        yield path
    for key, item in items:
        yield from leaves(item, (*path, key))


def at(value, place):
    for key in place:
        value = value[key]
    return value


def changed(document, path, new):
    """The document with one value replaced by what ``new`` makes of it."""
    other = deepcopy(document)
    place = at(other, path[:-1])
    place[path[-1]] = new(place[path[-1]])
    return other


assert set(SENTENCES) <= set(KINDS)
