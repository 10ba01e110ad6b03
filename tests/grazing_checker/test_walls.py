"""Walls as the checker reads them: what each sees, what is symmetric, what is refused; old certificates stay right."""

import json
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

import grazing as gz
from grazing.proof.certify import certify
from grazing_checker import Rejected, check, orbit
from grazing_checker.balls import around, double, number, precision
from grazing_checker.flight import Checked
from grazing_checker.flight import Path as Flight
from grazing_checker.oscillator import Problem
from grazing_checker.reading import exact
from grazing_checker.walls import Wall, frame, mirrored, read
from tests.examples import examples
from tests.grazing_checker.documents import WALLED, WALLED_VALUES, changed, claiming, documents, impact_pair
from tests.grazing_checker.forgeries import text_of

OLD = sorted((Path(__file__).parent / "version2").glob("*.json"))
NUMBERS = st.floats(-3.0, 3.0)
WAVES = st.lists(st.tuples(NUMBERS, NUMBERS), max_size=3)


@pytest.mark.parametrize("file", OLD, ids=lambda file: file.stem)
def test_certificates_that_were_made_before_there_were_walls_are_verified(file):
    """They were written by grazing 0.2.0 as it was then, and are never made anew."""
    assert check(file) == json.loads(file.read_text())["statement"]
    assert len(OLD) == 4


def names(pairs):
    return {
        f"{kind}{j}": double(x)
        for j, pair in enumerate(pairs, start=1)
        for kind, x in zip(("cos", "sin"), pair, strict=True)
    }


@settings(deadline=None, max_examples=examples(60))
@given(
    st.sampled_from([1, -1]), st.tuples(*[NUMBERS] * 4), st.floats(0.1, 3.0), WAVES.filter(len), WAVES, NUMBERS,
    NUMBERS,
)  # fmt: skip
def test_a_wall_sees_the_force_less_its_own_inertia(sign, scalars, omega, force, motion, sigma, t):
    alpha, stiffness, t0, offset = scalars
    p = {"alpha": alpha, "stiffness": stiffness, "omega": omega, "t0": t0, "offset": offset}
    wall = Wall("A", sign, "A", "law of A", "v", 1)
    with precision(200), mp.workdps(50):
        p_balls = {name: double(x) for name, x in p.items()} | names(force)
        seen = frame(wall, p_balls, {"sigma": double(sigma)} | names(motion), {}, {})

        def series(pairs, s):
            phase = [j * mpf(omega) * (s + mpf(t0)) for j in range(1, len(pairs) + 1)]
            return mp.fsum(mpf(c) * mp.cos(a) + mpf(d) * mp.sin(a) for (c, d), a in zip(pairs, phase, strict=True))

        def z(s):
            return mpf(sigma) + series(motion, s)

        at = mpf(t)
        lift = mp.diff(z, at, 2) + mpf(alpha) * mp.diff(z, at) + mpf(stiffness) * z(at)
        expected = sign * (mpf(offset) + series(force, at) - lift)
        assert abs(mpf(str(float(seen.motion.force(double(t)).mid()))) - expected) < 1e-9 * (1 + abs(expected))
        place, rate = seen.at(double(t))
        assert abs(float(place.mid()) - z(at)) < 1e-9 and abs(float(rate.mid()) - mp.diff(z, at)) < 1e-8


UNKNOWN = [("model", name) for name in ("alpha", "stiffness", "omega", "t0", "offset", "cos1", "sin2")]
UNKNOWN += [("wall", name) for name in ("sigma", "cos1", "sin2")]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("of", "unknown"), UNKNOWN)
def test_what_a_wall_sees_has_its_derivatives_by_every_parameter(sign, of, unknown):
    """Against difference quotients of places, speeds and forces."""
    p = {"alpha": 0.3, "stiffness": -0.7, "omega": 1.3, "t0": 0.4, "offset": 0.2}
    p |= {"cos1": 1.0, "sin1": 0.5, "cos2": -0.3, "sin2": 0.6}
    q = {"sigma": 0.4, "cos1": 0.2, "sin1": -0.1, "cos2": 0.15, "sin2": 0.05}
    wall, t, h = Wall("A", sign, "A", "law of A", "v", 1), number(7, -3), number(1, -60)

    def made(late):
        balls = [{name: double(x) for name, x in part.items()} for part in (p, q)]
        part = balls[of == "wall"]
        part[unknown] = part[unknown] + late
        slopes = {unknown: number(1)}
        return frame(wall, *balls, slopes if of == "model" else {}, slopes if of == "wall" else {})

    with precision(256):
        here, ahead, behind = (made(late) for late in (number(0), h, -h))
        m = here.motion
        for slope, one, two in zip(here.at_slope(t), ahead.at(t), behind.at(t), strict=True):
            assert abs(float(((one - two) / (2 * h) - slope).mid())) < 1e-25
        checked = Checked(m, sensitive=True)
        force, _bound = checked.force_slopes(t, [number(0)] * checked.K)
        quotient = (ahead.motion.force(t) - behind.motion.force(t)) / (2 * h)
        assert abs(float((force[0] - quotient).mid())) < 1e-25
        assert abs(float((m.slope("k2") - (unknown == "stiffness")).mid())) == 0.0


@pytest.mark.parametrize("name", ["pair", "rattle", "aloft", "inverted"])
def test_a_flight_is_the_same_for_both_walls(name):
    problem = Problem(documents()[name]["data"])
    with precision(256):
        one, two = problem.frames([number(0)] * problem.size)
        t, L, start = number(3, -2), number(5, -2), (number(1, -2), number(3, -3))
        first = Flight(Checked(one.motion), t, *start, L)
        second = Flight(Checked(two.motion), t, *one.seen_by(two, t, *start), L)
        ended = one.seen_by(two, t + L, first.y, first.v)
        for a, b in zip(ended, (second.y, second.v), strict=True):
            assert a.overlaps(b) and a.rad() < 1e-60 and b.rad() < 1e-60
        back = two.seen_by(one, t, *one.seen_by(two, t, *start))
        assert all(a.overlaps(b) for a, b in zip(back, start, strict=True))


@pytest.mark.parametrize("name", [*WALLED, *WALLED_VALUES])
def test_the_derivative_of_the_equations_is_that_of_difference_quotients(name):
    """By times, velocities and the unknown parameter, also over a box about the orbit."""
    data = documents()[name]["data"]
    unknown = (data["parameter"]["of"], data["parameter"]["name"]) if "parameter" in data else None
    problem, h = Problem(data, unknown), number(1, -60)
    with precision(256):
        x = [exact(text) for text in data["centre"]]
        D = problem.derivative(x, problem.legs(x, sensitive=unknown is not None))
        tiny = [around(one, number(1, -200)) for one in x]
        wide = None if unknown else problem.derivative(tiny, problem.wide_legs(x, tiny))
        for j in range(len(x)):
            ahead, behind = ([*x[:j], x[j] + by, *x[j + 1 :]] for by in (h, -h))
            columns = (problem.defect(at, problem.legs(at)) for at in (ahead, behind))
            for i, (one, two) in enumerate(zip(*columns, strict=True)):
                quotient = ((one - two) / (2 * h)).mid()
                assert abs(float((D[i][j] - quotient).mid())) < 1e-24 and D[i][j].rad() < 1e-40
                assert wide is None or (wide[i][j].overlaps(D[i][j]) and wide[i][j].rad() < 1e-40)


def shaken(**changes):
    law = {"parameters": {"r": (0.5).hex()}, "after": ["*", ["-", "r"], "v"]}
    data = {
        "model": {"k": 2.0, "offset": 1.0, "cos": [1.0, 0.0, 0.5], "sin": [0.0, -0.0, 0.0]},
        "walls": [
            {"sigma": -1.0, "cos": [0.5, 0.25], "sin": [0.0, 0.0], "law": law},
            {"sigma": 1.5, "cos": [0.5, -0.25, 0.0], "sin": [0.0, 0.0, 0.0], "law": deepcopy(law)},
        ],
    }
    for path, value in changes.items():
        *way, last = (int(key) if key.isdigit() else key for key in path.split("__"))
        place = data
        for key in way:
            place = place[key]
        place[last] = value
    return texts(data)


def texts(value):
    if isinstance(value, dict):
        return {key: texts(one) for key, one in value.items()}
    if isinstance(value, list):
        return [texts(one) for one in value]
    return value.hex() if isinstance(value, float) else value


@pytest.mark.parametrize(
    ("changes", "symmetric"),
    [
        ({}, True), ({"model__offset": 1.0 + 2.0**-52}, False), ({"model__k": 1.0}, False),
        ({"walls__1__sigma": 1.25}, False),
        ({"model__cos": [1.0, 2.0**-80, 0.5]}, False), ({"model__cos": [3.0, 0.0, 0.1]}, True),
        ({"walls__1__cos": [0.5, 0.25]}, False), ({"walls__1__cos": [-0.5, -0.25]}, False),
        ({"walls__1__cos": [0.5, -0.25, 1e-300], "walls__1__sin": [0.0, 0.0, 0.0]}, False),
        ({"walls__1__law__parameters": {"r": 0.25}}, False),
        ({"walls__0__sin": [0.5, 0.0], "walls__1__sin": [0.5, 0.0, 0.0]}, True),
        ({"walls__0__sin": [0.0, 0.5], "walls__1__sin": [0.0, 0.5, 0.0]}, False),
    ],
)  # fmt: skip
def test_a_model_is_its_own_mirror_image_exactly_or_not(changes, symmetric):
    assert mirrored(shaken(**changes)) == symmetric


def refused(document, said):
    with pytest.raises(Rejected, match=said):
        check(claiming(document))


def with_walls(name, new):
    return changed(documents()[name], ("data", "walls"), new)


def test_walls_that_are_none_are_refused():
    for name, said in (
        ("C", "a name that is none"),
        ("S", "none"),
        ("AB", "none"),
        ("a", "none"),
        ('A" is stable', "none"),
    ):
        refused(changed(documents()["pair"], ("data", "walls", 0, "name"), lambda _old, name=name: name), said)
    refused(changed(documents()["pair"], ("data", "walls", 1, "name"), lambda _old: "A"), "two walls have one name")
    refused(with_walls("pair", lambda walls: walls[::-1]), "not the lower one and the upper one")
    refused(with_walls("pair", lambda walls: [*walls, {**walls[1], "name": "D"}]), "neither one nor two walls")
    refused(with_walls("pair", lambda walls: walls[:1]), "at a wall that does not exist")
    for i, side in ((0, "above"), (1, "below")):
        refused(
            changed(documents()["pair"], ("data", "walls", i, "side"), lambda _old, side=side: side),
            "not the lower one",
        )
    refused(changed(documents()["table"], ("data", "walls", 0, "side"), lambda _old: "above"), "existence")


def test_another_wall_or_another_law_is_another_orbit():
    def exchanged(*names):
        def new(walls):
            one, two = deepcopy(walls)
            for name in names:
                one[name], two[name] = two[name], one[name]
            return [one, two]

        return new

    refused(with_walls("rattle", exchanged("law")), "existence")
    refused(with_walls("rattle", exchanged("sigma")), "existence")
    refused(with_walls("aloft", exchanged("cos", "sin")), "does not hold|is claimed")
    moved = changed(
        documents()["rattle"], ("data", "walls", 1, "sigma"), lambda text: (float.fromhex(text) + 2.0**-40).hex()
    )
    refused(moved, "existence")
    shaken = with_walls(
        "rattle", lambda walls: [walls[0], {**walls[1], "cos": [(2.0**-40).hex()], "sin": [(0.0).hex()]}]
    )
    refused(shaken, "existence")
    hits = documents()["rattle"]["data"]["impacts"]
    for other in (hits[::-1], hits[1:] + hits[:1], [{"A": "B", "B": "A"}[hit] for hit in hits]):
        if other != hits:
            refused(changed(documents()["rattle"], ("data", "impacts"), lambda _old, other=other: other), "existence")


def test_a_wall_that_no_flight_comes_near_may_stand_elsewhere_and_the_sentence_says_where():
    """It is another theorem, and true: the wall is moved by less than the clearance, or by more."""
    clearance = float(next(row["left"] for row in documents()["aloft"]["inequalities"] if "wall L" in row["name"]))
    for by in (0.9 * clearance, -2.5 * clearance):
        moved = changed(
            documents()["aloft"], ("data", "walls", 1, "sigma"), lambda text, by=by: (float.fromhex(text) + by).hex()
        )
        if by > 0:
            sigma = float.fromhex(moved["data"]["walls"][1]["sigma"])
            assert f"with L.sigma = {sigma!r}" in check(claiming(moved))
        else:
            refused(moved, "distance of the orbit from wall L is not proven")


def test_a_mirror_image_is_claimed_of_nothing_else():
    claims = ("data", "claims", "symmetric")
    for name, said in (("rattle", "no such orbit"), ("inverted", "no such orbit"), ("aloft", "the model is not")):
        refused(changed(documents()[name], claims, lambda _old: True), said)
    orbits = gz.periodic_orbits(gz.stroboscopic_map(impact_pair(0.5, 2.55)), word="(BA)", starts=60)
    broken = certify(next(one for one in orbits if one.stable)).document  # a symmetric model, and one of two images
    assert not broken["data"]["claims"]["symmetric"]
    refused(changed(broken, claims, lambda _old: True), "mirror image is not proven to be the orbit itself")
    slanted = changed(documents()["pair"], ("data", "walls", 1, "law", "parameters", "r"), lambda _old: (0.25).hex())
    refused(slanted, "existence|mirror")


def image_of_itself(monkeypatch, periods=1, hits=(0, 1), model=True, **moved):
    """What the claim asks of two impacts, at times 1 and 5 of a period 8, both with the velocity 3."""
    x = {"first": 1.0, "second": 5.0, "one": 3.0, "two": 3.0} | moved
    centre = [double(value) for value in x.values()]
    data = {"claims": {"symmetric": True}, "centre": [text_of(value) for value in centre], "unique": ["0x1p-9"] * 4}
    monkeypatch.setattr(orbit, "mirrored", lambda _data: model)
    seen = SimpleNamespace(period=number(8))
    orbit._symmetric(SimpleNamespace(n=2, N=periods, hits=[*hits], motion=lambda _box: seen), centre, data)


def test_a_mirror_image_needs_each_of_what_makes_it_one(monkeypatch):
    image_of_itself(monkeypatch)
    image_of_itself(monkeypatch, periods=3, second=13.0)
    for changes, said in (
        ({"periods": 2, "second": 9.0}, "no such orbit"), ({"hits": (0, 0)}, "not at the other walls"),
        ({"hits": (1, 1)}, "not at the other walls"), ({"model": False}, "the model is not"),
        ({"second": 5.01}, "not proven to be the orbit itself"), ({"first": 0.99}, "not proven to be the orbit itself"),
        ({"one": 3.01}, "not proven to be the orbit itself"), ({"two": 2.99}, "not proven to be the orbit itself"),
        ({"periods": 3}, "not proven to be the orbit itself"),
    ):  # fmt: skip
        with pytest.raises(Rejected, match=said):
            image_of_itself(monkeypatch, **changes)


def test_parameters_are_texts_in_groups_that_do_not_meet():
    walls, groups, hits = read(documents()["rattle"]["data"])
    assert [wall.name for wall in walls] == ["A", "B"] and sorted(groups) == ["A", "B", "law of A", "law of B", "model"]
    assert [walls[hit].name for hit in hits] == documents()["rattle"]["data"]["impacts"]
