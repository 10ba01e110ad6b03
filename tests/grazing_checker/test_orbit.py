"""Attacks on certificates of orbits: each hypothesis of the theorems is broken, with the sentence that then fits."""

from copy import deepcopy
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.proof.certify import certify
from grazing.proof.text import exact_text
from grazing_checker import Rejected, check, orbit
from grazing_checker.balls import Ball, double, number, precision
from grazing_checker.oscillator import Problem, spread
from grazing_checker.reading import exact
from grazing_checker.sentence import active_harmonics
from tests.examples import examples
from tests.grazing_checker.documents import changed, claiming, documents, resealed
from tests.grazing_checker.forgeries import fitting_matrix, newton, sealed
from tests.proof.orbits import closed, doubled, without_impacts

ORBITS = ("stable", "unstable", "free", "own")


def refused(document, said=None):
    with pytest.raises(Rejected, match=said):
        check(claiming(document))


def with_radius(document, radius):
    """Other half-widths, and rows that say what the test then needs, as far as it can be said."""
    forged = changed(document, ("data", "radius"), lambda _old: radius)
    for row, text in zip(forged["inequalities"], radius, strict=False):
        row["right"], row["left"] = text, str(float(Fraction(*half(text)))).upper()
    return forged


def half(text):
    mantissa, exponent = text.split("p")
    e = int(exponent) - 1
    return int(mantissa, 16) * 2 ** max(e, 0), 2 ** max(-e, 0)


@pytest.mark.parametrize("kind", ORBITS)
def test_half_widths_are_positive_and_smaller_than_those_of_uniqueness(kind):
    document = documents()[kind]
    r, u = document["data"]["radius"], document["data"]["unique"]
    for radius in (["-" + x for x in r], ["0x0p0"] * len(r), ["-0x0p0"] * len(r), [r[0], *["0x0p0"] * (len(r) - 1)], u):
        refused(with_radius(document, radius), "one inside the other")
    refused(changed(with_radius(document, ["-" + x for x in r]), ("data", "unique"), lambda u: ["-" + x for x in u]))
    refused(changed(document, ("data", "unique"), lambda _old: r), "one inside the other")
    with pytest.raises(Rejected, match="does not hold"):
        check(claiming(with_radius(document, [f"{x.split('p')[0]}p{int(x.split('p')[1]) - 400}" for x in r])))


@pytest.mark.parametrize("kind", ["stable", "unstable"])
def test_a_preconditioner_that_is_singular_scaled_or_negative_proves_nothing(kind):
    document = documents()[kind]
    C = np.array([[float.fromhex(x) for x in row] for row in document["data"]["preconditioner"]])
    first, zero = np.repeat(C[:1], len(C), axis=0), np.zeros_like(C)
    deficient = C.copy()
    deficient[-1] = C[:-1].sum(axis=0)
    for other in (first, zero, deficient, -C, 3.0 * C, C.T, C[::-1], 1e-300 * C, 1e300 * C):
        rows = [[float(x).hex() for x in row] for row in other]
        refused(
            changed(document, ("data", "preconditioner"), lambda _old, rows=rows: rows), "is false|does not hold|proven"
        )


@given(st.lists(st.floats(-4, 4), min_size=8, max_size=8), st.tuples(st.floats(0.1, 2), st.floats(0.1, 2)))
@settings(max_examples=examples(200))
def test_whatever_passes_the_test_of_contraction_is_regular(entries, u):
    C, D = ([[double(x) for x in entries[k : k + 2]] for k in (i, i + 2)] for i in (0, 4))
    widths = [double(x) for x in u]
    if all(a < b for a, b in zip(spread(C, D, widths), widths, strict=True)):
        a, b, c, d = (Fraction(x) for x in entries[:4])
        assert a * d != b * c


def test_no_cut_hides_a_flight_that_goes_through_the_wall():
    """Up to the first cut the ball only leaves, after the last one it only comes: its height is not asked for there."""
    base = documents()["stable"]
    data = deepcopy(base["data"])
    data["model"]["offset"] = (0.098).hex()  # beyond the graze at 0.09845
    with precision(256):
        newton(data)
        newton(data)
        fitting_matrix(None, data, [])
        (leg,) = Problem(data).legs([exact(text) for text in data["centre"]])
        assert leg.path.at(number(6)) < 0  # from 5.97 to 6.02, of 8.57
    start, end = data["cuts"][0]
    rows = [
        {**row, "left": "1E-90" if row["relation"] == ">" else "-1E-90"} if "cut" in row["name"] else row
        for row in base["inequalities"]
    ]
    for cuts, said in (
        ([start, end], "height of flight 1 between its cuts"),
        (["0x19p-2", end], "velocity of flight 1 up to its first cut"),
        ([start, "0x17p-2"], "velocity of flight 1 after its last cut"),
    ):
        data["cuts"] = [cuts]
        with pytest.raises(Rejected, match=f"{said} is not proven"):
            check(sealed(base["kind"], data, rows))


def test_impacts_come_in_the_order_of_time():
    document = documents()["unstable"]
    n = document["data"]["impacts"]

    def turned(row):
        return [*row[1:n], row[0], *row[n + 1 :], row[n]]

    forged = document
    for name in ("centre", "radius", "unique"):
        forged = changed(forged, ("data", name), turned)
    refused(forged, "order of time")


@pytest.mark.parametrize("name", ["alpha", "k", "omega"])
def test_rates_have_their_signs(name):
    document = documents()["free"]
    refused(changed(document, ("data", "model", name), lambda x: "-" + x), "out of range")
    if name == "omega":
        refused(changed(document, ("data", "model", name), lambda x: (0.0).hex()), "out of range")


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("precision",), 256.0), (("precision",), True), (("precision",), 64), (("precision",), 128),
        (("precision",), "256"),
        (("impacts",), True), (("impacts",), 1.0), (("impacts",), -1), (("periods",), 0), (("periods",), 3.0),
        (("periods",), 10**9), (("impacts",), 10**9), (("model", "cos"), []), (("model", "offset_name"), "force"),
        (("model", "sigma"), "inf"), (("model", "sigma"), "nan"), (("model", "sigma"), "0x1p0"),
        (("model", "sigma"), None),
        (("law", "parameters"), {"r": None, "V": (0.4).hex()}), (("claims", "least_period"), 1),
        (("claims", "apart"), []),
    ],
)  # fmt: skip
def test_values_of_another_type_or_out_of_range_are_refused(path, value):
    with pytest.raises(Rejected):
        check(resealed(changed(documents()["stable"], ("data", *path), lambda _old: value)))


def law_of(document, after, **parameters):
    law = {"parameters": {name: x.hex() for name, x in parameters.items()}, "after": after}
    return changed(document, ("data", "law"), lambda _old: law)


def test_a_law_into_the_wall_or_not_finite_proves_nothing():
    """Each gives no velocity away from the wall, at the impact of the orbit."""
    document = documents()["stable"]
    for after in (["-", ["abs", "v"]], "v", ["/", "V", ["-", "v", "v"]], ["*", "V", ["/", "v", (0.0).hex()]]):
        refused(law_of(document, after, V=0.4))


def test_the_bounds_on_a_law_are_over_the_whole_box():
    """A law that is right at the orbit, and another a little beside it: its comparison is not certain."""
    document = documents()["stable"]
    (low, high), right = document["data"]["claims"]["incoming"][0], document["data"]["law"]["after"]
    for v in (low, high):
        after = ["if", ["<", "v", float(v).hex()], right, ["*", (0.5).hex(), right]]
        refused(changed(document, ("data", "law", "after"), lambda _old, after=after: after), "not certain")


NAMES = ("alpha", "k", "omega", "t0", "offset", "d", "sigma", "v", "cos1", "sin1", "cos2", "sin7")


@pytest.mark.parametrize("name", NAMES)
def test_no_parameter_of_the_law_can_stand_for_one_of_the_model(name):
    """A name of the model's is refused; another one changes what the law says and nothing else."""
    for value in (0.0, 3.5):
        forged = changed(
            documents()["stable"], ("data", "law", "parameters"), lambda p, value=value: {**p, name: value.hex()}
        )
        refused(forged, "cannot be the name of a parameter")
    more = changed(documents()["stable"], ("data", "law", "parameters"), lambda p: {**p, "more": (3.5).hex()})
    assert "p.more = 3.5" in check(claiming(more))


def test_free_text_enters_no_sentence():
    text = "newton with r = 0.5; THEREFORE every orbit of it is stable (law"
    document = documents()["stable"]
    for path in (("law", "name"), ("law", "code"), ("model", "name"), ("name",), ("claims", "note")):
        forged = changed(document, ("data", *path[:-1]), lambda old, path=path: {**old, path[-1]: text})
        refused(forged, "lacks or adds")
    for path in (("law", "after"), ("model", "offset_name"), ("claims", "stability"), ("claims", "apart", 0)):
        forged = changed(document, ("data", *path), lambda _old: text)
        with pytest.raises(Rejected):
            check({**claiming(document), "data": forged["data"]})
        try:
            sealed = claiming(forged)
        except (KeyError, ValueError):
            continue
        with pytest.raises(Rejected):
            check(sealed)


HALF = gz.Oscillator(
    alpha=3.0, k=1.0, forcing=gz.Forcing(omega=1.1, offset=0.12, cos=(0.0, 1.0)), reset=gz.active(r=0.8, V=0.4)
)


def claims_least(document):
    return changed(document, ("data", "claims", "least_period"), lambda _old: True)


def divisor(document, q):
    """The row that the claim needs, with a bound as small as can be written."""
    row = {"name": f"least period, divisor {q}", "left": "1E-900", "relation": ">", "right": "0"}
    forged = claims_least(document)
    forged["inequalities"].append(row)
    return forged


def test_the_least_period_is_that_of_the_motion_whatever_the_period_of_the_forcing():
    """Only the second harmonic: the forcing repeats after T/2, and 2 impacts in 3 T may be one in 1.5 T."""
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    shift = 1.5 * HALF.period
    twice, _r = closed(HALF, 3, [orbit.tau, orbit.tau + shift], [orbit.v_plus] * 2, orbit.incoming.repeat(2))
    certificate = certify(twice)
    assert certificate.proven and not certificate.claims["least_period"]
    assert "in 3 periods T that meets" in certificate.statement
    assert check(certificate.document) == certificate.statement
    refused(claims_least(certificate.document), "'least period, divisor 2' is missing")
    refused(divisor(certificate.document, 2), "does not hold")


def test_an_orbit_of_one_impact_has_no_shorter_period():
    (orbit,) = (one for one in gz.one_impact_orbits(gz.pinball(d=0.05, V=0.4), 2) if one.admissible)
    once, _r = closed(HALF.replace(offset=0.05), 1, [orbit.tau], [orbit.v_plus], orbit.incoming)
    assert "with 1 impact in 1 period T, of least period 1 T," in certify(once).statement
    assert "with 1 impact in 3 periods T, of least period 3 T," in documents()["stable"]["statement"]


@pytest.mark.parametrize("kind", ["unstable"])
def test_a_doubled_orbit_has_its_least_period_and_says_so(kind):
    document = documents()[kind]
    assert "in 6 periods T, of least period 6 T," in document["statement"]
    assert [row["name"] for row in document["inequalities"]][-1] == "least period, divisor 2"
    worse = changed(document, ("inequalities", -1, "left"), lambda _old: "1")
    refused(worse, "does not hold")


#: Kernels are compiled for a number of harmonics: one, two, or six.
HARMONICS = [
    ((1.0,), (), 1), ((0.0, 1.0), (), 2), ((0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (), 3), ((0.0, -0.0), (), 0),
    ((0.0, 1.0, 0.5, 0.0, 0.0, 0.0), (), 1), ((0.0, 0.1, 0.0, 0.2, 0.0, 0.0), (), 2),
    ((0.0,) * 6, (0.0, 0.0, 0.5, 0.0, 0.0, 0.5), 3),
]  # fmt: skip


@pytest.mark.parametrize(("cos", "sin", "g"), HARMONICS)
def test_without_impacts_the_least_period_is_that_of_the_active_harmonics(cos, sin, g):
    model = gz.Oscillator(1.0, 1.0, gz.Forcing(omega=2.0, offset=2.0, cos=cos, sin=sin), gz.newton(r=0.5))
    certificate = certify(without_impacts(model))
    assert check(certificate.document) == certificate.statement
    assert active_harmonics(certificate.document["data"]["model"]) == g
    if g:
        assert f"in 1 period T, of least period {'T' if g == 1 else f'T/{g}'}, that stays" in certificate.statement
    else:
        assert "least period" not in certificate.statement
        refused(claims_least(certificate.document), "a constant force has no least period")


def test_exact_numbers_are_those_of_the_finder():
    for x in (number(-43, -7), number(0), number(5, 300)):
        assert (exact(exact_text(x)) - x).is_zero()


def test_a_doubled_orbit_in_a_forcing_of_half_the_period_is_told_from_two_of_one():
    """Doubled from 1 impact in 1.5 T, so 2 in 3 T: the finder proves that 1.5 T is no period of it."""
    edge = 0.12328144964392065
    other = doubled(gz.pinball(d=0.12, V=0.4), 3, "d", edge, 0.11)
    model = HALF.replace(offset=other.model.params["d"])
    same, _r = closed(model, 3, other.times, other.outgoing, other.incoming)
    certificate = certify(same)
    assert certificate.claims["least_period"] and "of least period 3 T," in certificate.statement
    assert check(certificate.document) == certificate.statement


def shorter(times, speeds, rates=None, hits=None, signs=(1, -1)):
    """Claim that 2 T = 12 is the least period of impacts, with the velocities that walls have then: what shows it."""
    n, asked, rates = len(times), {}, dict(zip(times, rates or [0.0] * len(times), strict=True))
    seen = [
        SimpleNamespace(
            motion=SimpleNamespace(period=number(6)), at=lambda t: (None, double(rates[float(t.mid())])), sign=s
        )
        for s in signs
    ]
    problem = SimpleNamespace(n=n, N=2, hits=hits or [0] * n, frames=lambda _box: seen)
    rows = SimpleNamespace(more=lambda name, x: asked.update({int(name.split()[-1]): x > 0}))
    box = [Ball(x, 1e-9) for x in [*times, *speeds]]
    orbit._least_period(problem, box, {"claims": {"least_period": True}}, rows)
    return asked


def test_a_shorter_period_repeats_all_times_and_velocities_at_the_same_walls():
    with precision(256):
        assert shorter([1.0, 7.0], [3.0, 3.0]) == {2: False}
        assert shorter([1.0, 7.5], [3.0, 3.0]) == shorter([1.0, 7.0], [3.0, 3.5]) == {2: True}
        assert shorter([1.0, 7.0], [3.0, 3.0], hits=[0, 1]) == {}
        assert shorter([1.0], [3.0]) == {}
        four = [0.0, 1.0, 6.0, 7.0]
        assert shorter(four, [3.0, 2.0, 3.0, 2.0]) == shorter(four, [3.0, 2.0] * 2, hits=[0, 1, 0, 1]) == {2: False}
        assert shorter(four, [3.0, 2.0, 3.0, 1.0]) == shorter([*four[:3], 8.0], [3.0, 2.0] * 2) == {2: True}
        assert shorter([1.0, 5.0, 9.0], [3.0] * 3) == {3: False}
        half, third = [0.0, 1.0, 3.0, 6.0, 7.0, 9.0], [0.0, 1.0, 4.0, 5.0, 8.0, 9.0]
        assert shorter(half, [3.0] * 6) == {2: False, 3: True} and shorter(third, [3.0] * 6) == {2: True, 3: False}
        assert shorter([2.0 * i for i in range(6)], [3.0] * 6) == {2: False, 3: False}


@pytest.mark.parametrize("sign", [1, -1])
def test_it_is_the_velocity_of_the_ball_that_repeats_and_not_that_off_a_wall_that_moves(sign):
    """Above the ball the velocity off the wall counts downwards."""
    with precision(256):
        assert shorter([1.0, 7.0], [3.0, 2.5], rates=[0.5, 0.5 + 0.5 * sign], signs=[sign]) == {2: False}
        assert shorter([1.0, 7.0], [3.0, 3.0], rates=[0.5, 1.0], signs=[sign]) == {2: True}
