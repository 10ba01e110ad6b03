"""Certificates of the gap map: every hypothesis of their theorems is demanded, and what was forged is refused."""

import json
import random
import re
from copy import deepcopy

import pytest

from grazing.proof.gap import certify_gap_orbit
from grazing_checker import Rejected, check, gap, orbit, oscillator, reading
from grazing_checker.balls import precision
from grazing_checker.envelope import seal
from tests.grazing_checker.bases import GAP_NAMES, KINDS, bases, gap_bases
from tests.grazing_checker.documents import resealed
from tests.grazing_checker.forgeries import (
    at,
    fit,
    fitting_matrix,
    forgeries,
    is_decimal,
    leaves,
    newton,
    orthogonal,
    put,
    sealed,
)
from tests.grazing_checker.truth import is_true

ORBIT, EDGE, NO_ATTRACTOR = KINDS[-3:]


def forged(name, path, value):
    """A certificate of the gap map with one value changed, and all the rest made to fit."""
    document = gap_bases()[name]
    data = deepcopy(document["data"])
    put(data, path, value)
    return sealed(document["kind"], data, document["inequalities"], honest=path[0] != "claims")


@pytest.mark.parametrize("name", GAP_NAMES)
def test_as_made_it_passes(name):
    document = json.loads(json.dumps(gap_bases()[name]))
    assert check(document) == document["statement"]


@pytest.mark.parametrize("name", GAP_NAMES)
def test_every_single_change_is_refused_unless_it_is_sealed_again(name):
    for path in leaves(gap_bases()[name]):
        document = deepcopy(gap_bases()[name])
        value = at(document, path)
        put(
            document,
            path,
            not value if isinstance(value, bool) else value + 1 if isinstance(value, int) else value + "1",
        )
        with pytest.raises(Rejected):
            check(document)


def test_a_negative_radius_proves_nothing():
    """|Y F(m)| + |I - Y D| r < r holds for r < 0 where |I - Y D| is large, whatever F(m) is."""
    data = {"lam": (0.9).hex(), "l": (0.0).hex(), "word": "R", "edge": "pd", "at": 0}
    data |= {"centre": ["0x1p-1", "0x133p-10"], "preconditioner": [["0x0.0p+0", (5.0).hex()]] * 2}
    claims = {"roots": [["0", "0"]], "apart": "0.1", "value": ["0", "0"]}
    for radius, unique in (
        ("-0x1p-80", "0x1p-3"),
        ("-0x1p-80", "-0x1p-90"),
        ("-0x1p-3", "-0x1p-3"),
        ("0x0p0", "0x1p-3"),
    ):
        document = sealed(EDGE, {**data, "radius": radius, "unique": unique, "claims": claims}, [])
        with pytest.raises(Rejected, match="the radii are not 0 < radius < unique"):
            check(document)
    # the true one is at mu = 0.75, and a regular matrix proves it
    (true,) = (one for one in gap_bases().values() if one["data"].get("word") == "R" and "edge" in one["data"])
    low, high = map(float, true["data"]["claims"]["value"])
    assert low < 0.75 < high and check(true) == true["statement"]


def test_a_stable_orbit_where_there_is_none_is_not_proven():
    # at mu = 0.6 the orbit R repels: its root is below 1/2
    claims = {"roots": [["0", "0"]], "apart": "0.1", "multiplier": ["0", "0"], "stable": True}
    data = {name: value.hex() for name, value in (("lam", 0.5), ("mu", 0.6), ("l", 0.0))}
    for radius in ("-0x1p-80", "-0x1p-2", "0x0p0"):
        for entry in (0.0, 5.0, -5.0):
            made = {**data, "word": "R", "centre": ["0xcp-4"], "radius": radius, "unique": "0x1p-1"}
            made |= {"preconditioner": [[entry.hex()]], "claims": claims}
            with pytest.raises(Rejected, match="radii"):
                check(sealed(ORBIT, made, []))
            with pytest.raises(Rejected, match="existence and uniqueness"):
                check(sealed(ORBIT, {**made, "radius": "0x1p-2"}, []))


#: What stands between a forger and a false theorem, by kind: words of demands.
GUARDS = {
    ORBIT: ("the radii are not",),
    EDGE: ("the radii are not",),
    "periodic orbit": ("the boxes are not one inside the other", "a half-width is negative"),
}


@pytest.mark.parametrize("kind", GUARDS)
def test_the_forger_finds_a_false_theorem_once_a_hypothesis_is_left_out(kind, monkeypatch):
    def lax(holds, said):
        if not said.startswith(GUARDS[kind]):
            reading.demand(holds, said)

    for module in (gap, orbit, oscillator):
        monkeypatch.setattr(module, "demand", lax)
    for _ways, document in forgeries(kind, list(bases().values()), 60, "lax", (orthogonal,)):
        try:
            check(document)
        except Rejected:
            continue
        if not is_true(kind, document["data"])[0]:
            return
    raise AssertionError("no lie was found")


#: What a forger would have to change, and what gives him away.
FORGED = [
    ("LLRLR", ("mu",), (0.1001).hex(), "existence and uniqueness"),
    ("LLRLR", ("lam",), (0.9001).hex(), "existence and uniqueness"),
    ("LLRLR", ("l",), (0.051).hex(), "existence and uniqueness"),
    ("LLRLR", ("l",), "nan", "no finite double"),
    ("LLRLR", ("l",), "0.05", "no finite double"),
    ("LLRLR", ("l",), 0.05, "no double"),
    ("LLRLR", ("word",), "LLLRR", "existence and uniqueness"),
    ("LLRLR", ("word",), "LLRLRLLRLRLLRLR", "centre is no list of 6"),
    ("LLRLR", ("word",), "LLLLL", "with an R"),
    ("LLRLR", ("word",), "L" * 1000 + "R", "1 to 1000 letters"),
    ("LLRLR", ("word",), "L" + "R" * 301, "more than 300 letters R"),
    ("LLRLR", ("word",), ["L", "R"], "1 to 1000 letters"),
    ("LLRLR", ("claims", "stable"), True, "1 - multiplier"),
    ("LLRLR", ("claims", "stable"), "yes", "stable is not true or false"),
    ("LLRLR", ("claims", "stable"), 1, "stable is not true or false"),
    ("LLRLR", ("claims", "apart"), "0.9", "alone within the distance"),
    ("LLRLR", ("claims", "apart"), "-0.1", "alone within the distance"),
    ("LLRLR", ("claims", "apart"), "0", "alone within the distance"),
    ("LLRLR", ("radius",), "0x1p-1", "0 < radius < unique"),
    ("LLRLR", ("radius",), "-0x1p-80", "0 < radius < unique"),
    ("LLRLR", ("radius",), "1p-80", "no exact number"),
    ("LLRLR", ("radius",), "0x1p-9999999", "no exact number"),
    ("LLRLR", ("radius",), "0x2p-81", "existence|the right side|in this form|no exact"),
    ("LLRLR", ("unique",), "0x1p4", "existence and uniqueness"),
    ("LLRLR", ("unique",), "0x1p-120", "0 < radius < unique"),
    ("LLRLR", ("centre", 0), "0x1p-1", "existence and uniqueness"),
    ("LLRLR", ("centre", 0), "x", "no exact number"),
    ("LLRLR", ("preconditioner", 0), [], "no 2 by 2 matrix"),
    ("LLRLLR", ("word",), "LLR", "centre is no list of 1"),
    ("gap bc", ("edge",), "pd", "no such point"),
    ("gap bc", ("edge",), "ns", "not one of gr, bc, pd, lp"),
    ("gap bc", ("edge",), ["bc"], "not one of gr, bc, pd, lp"),
    ("gap bc", ("at",), 1, "existence and uniqueness"),
    ("gap bc", ("at",), 3, "no such point"),
    ("gap bc", ("at",), 0, "no such point"),
    ("gap bc", ("at",), -1, "no such point"),
    ("gap bc", ("at",), True, "no such point"),
    ("gap bc", ("l",), (0.41).hex(), "existence and uniqueness"),
    ("gap bc", ("centre", 1), "0x1p-2", "existence and uniqueness"),
    ("gap bc", ("claims", "value"), ["0.1", "nan"], "no decimal"),
    ("gap pd", ("edge",), "lp", "existence and uniqueness"),
    ("gap pd", ("at",), False, "no such point"),
    ("gap pd", ("word",), "LLR", "existence and uniqueness"),
    ("small", ("high",), (0.19).hex(), "one letter always occurs"),
    ("small", ("l",), (0.01).hex(), "needs l = 0"),
    ("small", ("l",), (-0.01).hex(), "l is negative"),
    ("small", ("lam",), (0.6).hex(), "stretches|K_"),
    ("small", ("lam",), (1.0).hex(), "lam is not between 0 and 1"),
    ("small", ("lam",), (-0.9).hex(), "lam is not between 0 and 1"),
    ("small", ("turns",), [], "there are not 1 to 5000 turns"),
    ("small", ("turns",), [(0.18).hex()] * 5001, "there are not 1 to 5000 turns"),
    ("small", ("turns", 0), (0.5).hex(), "outside the interval"),
    ("between", ("high",), (0.31).hex(), "one letter always occurs"),
    ("between", ("low",), (0.27).hex(), "does not occur"),
    ("between", ("low",), (0.0).hex(), "needs l = 0"),
    ("between", ("low",), (0.3).hex(), "0 <= low < high"),
    ("between", ("turns", 0), (0.28).hex(), "one letter always occurs"),
    ("between", ("turns", 1), (0.28).hex(), "does not occur|stretches"),
]


@pytest.mark.parametrize(("name", "path", "value", "said"), FORGED)
def test_a_new_seal_does_not_help(name, path, value, said):
    document = forged(name, path, value)
    try:
        assert check(document) == gap_bases()[name]["statement"] and value == "0x2p-81"  # the same number
    except Rejected as error:
        assert re.search(said, str(error)), error


@pytest.mark.parametrize("name", GAP_NAMES)
def test_every_number_by_sign_zero_and_scale(name):
    """What is accepted of it is the same theorem, or another true one."""
    document = gap_bases()[name]
    tried = 0
    for path in leaves(document["data"]):
        text = at(document["data"], path)
        if not isinstance(text, str) or path[-1] in ("word", "edge"):
            continue
        for value in scaled(text):
            one = forged(name, path, value)
            if one["data"] == document["data"]:
                continue
            tried += 1
            try:
                said = check(one)
            except Rejected:
                continue
            if said != document["statement"]:
                assert is_true(document["kind"], one["data"]) == (True, ""), (path, value)
    assert tried > 15


def scaled(text):
    """The number with the other sign, zero, and of other sizes, in the same form."""
    if "." in text and text.lstrip("-").startswith("0x"):
        x = float.fromhex(text)
        return [value.hex() for value in (-x, 0.0, x / 2, 2 * x, x * 1e-9, x * 1e9)]
    if is_decimal(text):
        x = float(text)
        return [f"{value!r}".upper().replace("E+", "E") for value in (-x, 0.0, x / 2, 2 * x, x * 1e-9, x * 1e9)]
    m, e = text.split("p")
    m, e = int(m, 16), int(e)
    return [
        f"{value:#x}p{power}" for value, power in ((-m, e), (0, 0), (m, e - 1), (m, e + 1), (m, e - 40), (m, e + 40))
    ]


@pytest.mark.parametrize("name", ["LLR", "gap pd", "small"])
def test_statement_trusted_base_and_inequalities_are_held_against_the_data(name):
    document = gap_bases()[name]
    for path, value, said in (
        (("statement",), "The gap map is chaotic.", "what follows is"),
        (("trusted_base",), document["trusted_base"][:-1], "trusted base"),
        (("kind",), "gap map", "its kind is"),
        (("inequalities",), document["inequalities"][1:], "inequality"),
        (("inequalities",), [*document["inequalities"], document["inequalities"][0]], "not one of this proof"),
        (("inequalities", 0, "left"), "much", "no decimal"),
        (("inequalities", 0, "relation"), "!=", "the relation of"),
        (("inequalities", 0, "right"), "9", "the right side"),
        (("inequalities", 0, "name"), "existence", "expected is"),
        (("data", "note"), "hello", "lacks or adds note"),
    ):
        other = deepcopy(document)
        put(other, path, value)
        with pytest.raises(Rejected, match=said):
            check(resealed(other))


def test_one_kind_does_not_pass_for_another():
    for document in gap_bases().values():
        for kind in KINDS:
            if kind != document["kind"]:
                other = seal(
                    kind, document["statement"], document["trusted_base"], document["data"], document["inequalities"]
                )
                with pytest.raises(Rejected):
                    check(other)


@pytest.mark.parametrize(("name", "times"), [("LLRLR", 3), ("gap lp", 2)])
def test_a_cycle_gone_round_more_often_has_no_longer_period(monkeypatch, name, times):
    """It is alone in its box: roots half of three turns apart differ, and twice a fold has the multiplier 1."""
    base = gap_bases()[name]
    data, k = deepcopy(base["data"]), base["data"]["word"].count("R")
    data["word"], data["claims"]["roots"] = times * data["word"], times * data["claims"]["roots"]
    data["centre"] = [*times * data["centre"][:k], *data["centre"][k:]]
    data["radius"], data["unique"] = "0x1p-60", "0x1p-50"
    fit(data)
    with precision(256):
        newton(data)
    fitting_matrix(None, data, [])
    with monkeypatch.context() as lax:
        lax.setattr(gap, "demand", lambda holds, said: "repeats" in said or reading.demand(holds, said))
        document = sealed(base["kind"], data, base["inequalities"])
        assert check(document) == document["statement"]
    with pytest.raises(Rejected, match="repeats a shorter one"):
        check(document)


def test_the_fixed_point_right_of_the_border_cannot_be_left_out():
    # at mu = 2 blocks of two letters and more do not occur, but R attracts
    data = {"lam": (0.9).hex(), "l": (0.0).hex(), "low": (2.0).hex(), "high": (3.0).hex()}
    for turns in ([], [(2.0).hex()], [(2.5).hex()], [(3.0).hex()]):
        with pytest.raises(Rejected):
            check(sealed(NO_ATTRACTOR, {**data, "turns": turns}, []))


@pytest.mark.parametrize("name", ["LLR", "LLRLR", "gap bc of two"])
def test_places_are_those_of_the_word_wherever_it_begins(name):
    """Turned by a letter it is the same cycle: the roots turn with it."""
    data = deepcopy(gap_bases()[name]["data"])
    word = gap.Word(data["word"])
    points = {j: (place.root, place.q) for j, place in enumerate(word.places)}
    n, k = len(word.letters), word.k
    for i in range(n):
        turned = gap.Word(data["word"][i:] + data["word"][:i])
        before = data["word"][:i].count("R")
        for j in range(n):
            root, q = turned.places[j]
            assert points[(i + j) % n] == ((root + before) % k, q)


def test_what_is_proven_of_any_map_is_true():
    rng, proven = random.Random(3), 0
    while proven < 60:
        word = "".join(rng.choice("LR") for _ in range(rng.randint(1, 6))) * rng.choice((1, 1, 1, 2))
        lam, mu, l = (
            rng.choice((rng.uniform(-1.3, 1.5), 0.0)),
            rng.uniform(-0.3, 1.2),
            rng.choice((0.0, rng.uniform(-1, 1))),
        )
        if "R" in word and (document := certify_gap_orbit(word, lam, mu, l).document):
            assert check(document) == document["statement"]
            assert is_true(ORBIT, document["data"]) == (True, "")
            proven += 1
