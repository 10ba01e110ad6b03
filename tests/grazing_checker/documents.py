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

WALLED = ("pair", "rattle", "table", "inverted", "aloft", "doubled table", "caught")
WALLED_VALUES = ("table pd", "table lp", "rattle gr", "aloft gr", "law pd")
NAMES = ("stable", "unstable", "free", "own", "pd", "gr", "lp", "ns", *WALLED, *WALLED_VALUES)
SENTENCES = {
    "periodic orbit": orbit_sentence,
    "periodic orbit with walls": orbit_sentence,
    "bifurcation value": value_sentence,
    "bifurcation value with walls": value_sentence,
}
#: Numbers that only help to prove: not unique, and not part of the statement.
WITNESSES = {("data", "preconditioner"), ("data", "ends")}


def own_model():
    return gz.Oscillator(
        alpha=1.5, k=1.2, forcing=gz.Forcing(omega=2.2, offset=0.05), sigma=0.02, reset=gz.reset(cubic, e=0.8, c=0.5)
    )


def walled(alpha, spring, forcing, *walls):
    return gz.Oscillator(alpha, **spring, forcing=forcing, walls=walls)


def found_in(model, word, **wanted):
    """The one orbit of a word that a model has, among those with these properties."""
    period = wanted.get("period", 1)
    sought = {"word": word} if period == 1 else {"period": period}  # that of a word is the shortest
    orbits = gz.periodic_orbits(gz.stroboscopic_map(model), **sought, starts=30)
    (orbit,) = (
        one for one in orbits if all(getattr(one, name) == value for name, value in wanted.items()) and one.word == word
    )
    return orbit


def impact_pair(r=0.5, gap=3.0):
    """A ball without a spring in a box that shakes."""
    shake, still = gz.Forcing(omega=1.0, sin=(1.0,), cos=()), gz.Forcing(omega=1.0, cos=())
    sides = (gz.wall(side * gap / 2, gz.newton(r), motion=shake) for side in (-1, 1))
    return walled(0.0, {"k": 0.0}, still, *sides)


def vibrating_table(r, amplitude):
    """A ball that falls on a table which moves up and down."""
    shake, fall = gz.Forcing(omega=1.0, sin=(amplitude,), cos=()), gz.Forcing(omega=1.0, offset=-1.0, cos=())
    return walled(0.0, {"k": 0.0}, fall, gz.wall(0.0, gz.newton(r), motion=shake))


def rattle(sigma=0.5):
    sides = gz.wall(-0.5, gz.newton(0.8)), gz.wall(sigma, gz.newton(0.6))
    return walled(0.1, {"k": 0.5}, gz.Forcing(omega=2.0, cos=(2.0,)), *sides)


def inverted():
    sides = gz.wall(-0.4, gz.newton(0.6)), gz.wall(0.4, gz.newton(0.6))
    return walled(0.3, {"stiffness": -1.0}, gz.Forcing(omega=2.0, cos=(1.5,)), *sides)


def catching():
    """The upper wall takes all speed, and the force lifts the ball off it at once."""
    sides = gz.wall(-1.2, gz.newton(0.5)), gz.wall(1.2, gz.newton(0.0))
    return walled(0.5, {"k": 1.0}, gz.Forcing(omega=1.5, offset=-0.5, cos=(2.0,)), *sides)


def walled_orbits():
    """Orbits between walls that are at rest or move, with springs of either sign and without, by name."""
    nod = gz.Forcing(omega=4.0, cos=(0.1,), sin=(0.05,))
    sides = gz.wall(-1.4, gz.newton(0.6), motion=nod), gz.wall(1.4, gz.reset(cubic, e=0.8, c=0.5), name="L")
    aloft = walled(0.5, {"k": 1.0}, gz.Forcing(omega=2.0, cos=(0.5,)), *sides)
    found = {
        "pair": found_in(impact_pair(), "(BA)", stable=True),
        "rattle": found_in(rattle(), "(BAB)", stable=False),
        "table": found_in(vibrating_table(0.5, 1.4), "1", stable=True),
        "inverted": found_in(inverted(), "A"),
        "aloft": found_in(aloft, "0"),
        "doubled table": found_in(vibrating_table(0.5, 1.6), "1", period=2),
        "caught": found_in(catching(), "(BA)"),
    }
    assert tuple(found) == WALLED
    return found


@cache
def documents():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    (fold,) = (o for o in gz.one_impact_orbits(gz.pinball(alpha=0.2, omega=2.8, V=0.0, d=0.55), 2) if o.stable)
    (ns,) = gz.one_impact_orbits(gz.pinball(alpha=0.05, d=0.1), 1)
    walled = walled_orbits()
    found = {
        "stable": certify(orbit),
        "unstable": certify(doubled(gz.pinball(d=0.12, V=0.4), 3, "d", 0.12328144964392065, 0.11)),
        "free": certify(without_impacts(gz.pinball(d=0.14))),
        "own": certify(attractor(own_model(), (0.2, 0.1), 1)),
        "pd": enclose(orbit, "pd", "V"),
        "gr": enclose(orbit, "gr", "d"),
        "lp": enclose(fold, "lp", "d"),
        "ns": enclose(ns, "ns", "r"),
        **{name: certify(orbit) for name, orbit in walled.items()},
        "table pd": enclose(walled["table"], "pd", "omega"),
        "table lp": enclose(walled["table"], "lp", "A.sin1"),
        "rattle gr": enclose(found_in(rattle(sigma=0.396), "(AB)"), "gr", "B.sigma"),
        "aloft gr": enclose(walled["aloft"], "gr", "A.sigma"),
        "law pd": enclose(walled["table"], "pd", "r"),
    }
    assert tuple(found) == NAMES
    return {name: certificate.document for name, certificate in found.items()}


def resealed(document):
    return seal(*(document[name] for name in ("kind", "statement", "trusted_base", "data", "inequalities")))


def claiming(document):
    """The same with the sentence that its data make, sealed again; what a forger would do."""
    said = SENTENCES[document["kind"]](document["data"])
    return resealed({**document, "statement": said, "trusted_base": trusted_base(document["kind"])})


def alike(paths):
    """Return the first, the middle and the last of paths that differ in no more than places in lists."""
    groups = {}
    for path in paths:
        groups.setdefault(tuple("*" if isinstance(part, int) else part for part in path), []).append(path)
    return [path for group in groups.values() for path in dict.fromkeys((group[0], group[len(group) // 2], group[-1]))]


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
    if not path:
        return new(other)
    place = at(other, path[:-1])
    place[path[-1]] = new(place[path[-1]])
    return other


assert set(SENTENCES) <= set(KINDS)
