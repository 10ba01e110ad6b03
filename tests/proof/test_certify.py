import json
from copy import copy
from dataclasses import replace
from time import process_time

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.orbit import Orbit
from grazing.orbits.signature import flown
from grazing.orbits.windows import windows
from grazing.proof.certify import certify
from grazing.proof.check import check_certificate
from grazing_checker import flight
from tests.models import MODELS, TWO, TWO_HARMONICS, cubic
from tests.proof.orbits import attractor, closed, doubled, without_impacts

PINBALL = gz.pinball(V=0.4)


@pytest.fixture(scope="module")
def table():
    found = windows(PINBALL, "d", N=range(2, 8))
    return {int(row.N): (float(row.low), float(row.high)) for row in (found.isel(window=i) for i in range(6))}


def proven(orbit, law=None):
    """The certificate of an orbit, proven and found right by the checker."""
    certificate = certify(orbit)
    assert certificate.proven, certificate.reason
    assert check_certificate(certificate.document, law=law) == certificate.statement
    return certificate


def claimed(certificate, name):
    return [[float(x) for x in pair] for pair in certificate.claims[name]]


@pytest.mark.parametrize("prove", [certify, lambda orbit: gz.enclose(orbit, "pd", "V")], ids=["orbit", "value"])
def test_nothing_is_called_proven_that_takes_the_checker_too_much_work(prove, monkeypatch):
    """The orbit without impacts in 430 periods was, and its certificate was refused."""
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    assert prove(orbit).proven
    monkeypatch.setattr(flight, "MOST_WORK", 100_000)
    refused = prove(orbit)
    assert not refused.proven and refused.document is None
    assert "the checker does not accept the certificate: checking it takes too much work" in refused.reason


def test_the_stable_orbits_of_every_window_are_proven_stable_in_time(table):
    for N, (low, high) in table.items():
        (orbit,) = (o for o in gz.one_impact_orbits(PINBALL.replace(d=(low + high) / 2), N) if o.admissible)
        start = process_time()
        certificate = certify(orbit)
        assert process_time() - start < 2.0
        assert certificate.claims["stability"] == "stable"
        assert certificate.claims["least_period"]
        assert check_certificate(certificate.document) == certificate.statement
        (t, w), (v,) = claimed(certificate, "box"), claimed(certificate, "incoming")
        assert t[0] - 1e-12 < orbit.tau < t[1] + 1e-12
        assert w[0] - 1e-12 < orbit.v_plus < w[1] + 1e-12
        assert v[0] - 1e-12 < orbit.v_minus < v[1] + 1e-12
        for one, mu in zip(certificate.claims["multipliers"], orbit.multipliers, strict=True):
            assert abs(float(one["real"][0]) - mu.real) < 1e-9


def test_the_doubled_orbits_are_proven_unstable_in_time(table):
    for N, (low, high) in table.items():
        orbit = doubled(PINBALL, N, "d", high, low)
        start = process_time()
        certificate = certify(orbit)
        assert process_time() - start < 2.0
        assert certificate.claims["stability"] == "unstable"
        assert certificate.claims["least_period"]
        assert "2 impacts in" in certificate.statement
        assert check_certificate(certificate.document) == certificate.statement


K0 = gz.pinball(alpha=1.0, k=0.0, d=-0.2, V=0.2, r=0.6)
OWN = gz.Oscillator(
    alpha=1.5, k=1.2, forcing=gz.Forcing(omega=2.2, offset=0.05), sigma=0.02, reset=gz.reset(cubic, e=0.8, c=0.5)
)


@pytest.mark.parametrize(
    ("model", "periods", "impacts", "law"),
    [
        (MODELS["passive"], 2, 1, None),
        (MODELS["critical"], 1, 1, None),
        (MODELS["under-damped"], 2, 4, None),
        (TWO_HARMONICS, 1, 1, None),
        (MODELS["stick"], 2, 1, None),  # leaves the wall at rest, lifted by the force
        (MODELS["trigger"], 2, 3, None),
        (K0, 2, 1, None),
        (gz.pinball(alpha=0.0, k=0.7, d=-0.3, V=0.05, r=0.4), 1, 1, None),
        (gz.pinball(alpha=0.0, k=0.0, d=-0.55, V=0.05, r=0.4), 2, 2, None),
        (OWN, 1, 1, cubic),
    ],
    ids=["passive", "critical", "under-damped", "harmonics", "at rest", "trigger", "k = 0", "undamped", "free", "own"],
)
def test_attractors_of_all_kinds_of_models_are_proven(model, periods, impacts, law):
    rng = np.random.default_rng(1)
    starts = ((model.sigma + rng.uniform(0.01, 0.5), rng.uniform(-0.5, 0.5)) for _ in range(40))
    orbits = (attractor(model, start, periods) for start in starts)
    orbit = next(orbit for orbit in orbits if orbit is not None and orbit.impacts == impacts)
    certificate = proven(orbit, law)
    assert certificate.claims["stability"] == "stable"
    t, w = np.split(np.array(claimed(certificate, "box")), 2)
    assert (abs(t[:, 0] - orbit.times) < 1e-9).all()
    assert (abs(w[:, 0] - orbit.outgoing) < 1e-9).all()


@pytest.mark.parametrize(
    "model",
    [
        gz.pinball(d=0.14), MODELS["stiff"], gz.pinball(alpha=0.0, k=3.0, d=3.0),
        gz.pinball(alpha=2.0, d=1.0, sigma=0.3),
        gz.Oscillator(alpha=0.5, k=1.3, forcing=TWO, sigma=-1.5, reset=gz.newton(r=0.7)),
    ],
)  # fmt: skip
def test_orbits_without_impacts_are_proven(model):
    certificate = proven(without_impacts(model))
    assert certificate.claims["stability"] == ("stable" if model.alpha else "undecided")
    assert "no impacts" in certificate.statement
    neutral = "without damping and impacts both multipliers are on the unit circle, and nothing attracts or repels"
    assert certificate.reason == ("" if model.alpha else f"stability is not decided: {neutral}")


def test_an_undamped_elastic_orbit_exists_but_nothing_is_claimed_of_its_stability():
    model = gz.pinball(r=1.0, V=0.0, alpha=0.0, k=0.5, d=-0.3)
    orbits = [o for o in gz.one_impact_orbits(model, 2) if o.admissible]
    found = {certify(o).claims["stability"]: certify(o) for o in orbits}
    assert set(found) == {"undecided", "unstable"}
    certificate = found["undecided"]
    assert certificate.proven and "determinant 0.9999" in certificate.reason
    assert "nothing is claimed of its stability" in certificate.statement
    assert check_certificate(certificate.document) == certificate.statement


def test_an_orbit_given_twice_over_is_not_said_to_have_the_longer_period():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    T = orbit.model.period
    twice, _residual = closed(
        orbit.model, 6, [orbit.tau, orbit.tau + 3 * T], [orbit.v_plus] * 2, np.array([-0.1, -0.1])
    )
    certificate = proven(twice)
    assert not certificate.claims["least_period"]
    assert "least period" not in certificate.statement


def test_a_virtual_orbit_says_where_it_passes_through_the_wall():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.05, V=0.4), 3)
    assert not orbit.admissible
    certificate = certify(orbit)
    assert not certificate.proven and certificate.document is None and certificate.claims == {}
    assert "virtual: flight 1 passes through the wall, u - sigma = -0.04" in certificate.reason
    assert certificate.statement == f"Nothing is proven: {certificate.reason}."
    with pytest.raises(gz.InputError, match="nothing to save: the orbit is virtual"):
        certificate.save("nowhere.json")


def rooted(v, p):
    return (v * v) ** 0.5 * float(p.e) if isinstance(v, float) else -p.e * v + len(v)


def test_a_law_that_balls_cannot_take_is_named():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    forcing = gz.Forcing(omega=2.2, offset=0.12)
    model = gz.Oscillator(alpha=3.0, k=1.0, forcing=forcing, reset=gz.reset(rooted, e=0.8))
    certificate = certify(replace(orbit, map=gz.stroboscopic_map(model)))
    assert not certificate.proven
    assert "cannot be written as an expression (TypeError" in certificate.reason
    assert "arithmetic, comparisons and abs of its arguments only" in certificate.reason


def test_a_guess_that_is_far_off_is_named():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    certificate = certify(replace(orbit, times=orbit.times + 0.3, outgoing=orbit.outgoing + 0.5))
    assert not certificate.proven
    assert "Newton's method" in certificate.reason and "smaller residual" in certificate.reason


def test_at_a_graze_itself_nothing_is_proven():
    graze = gz.normal_form(gz.pinball(), "d").graze
    assert certify(without_impacts(gz.pinball(d=np.nextafter(graze, 1)))).proven
    below = certify(without_impacts(gz.pinball(d=np.nextafter(np.nextafter(graze, 0), 0))))
    assert not below.proven and "passes through the wall" in below.reason


def test_an_orbit_of_a_section_is_flown_first():
    model = gz.pinball(d=0.12, V=0.4)
    orbit = attractor(model, (0.2, 0.0), 3)
    plain = Orbit(**{name: getattr(orbit, name) for name in Orbit.__dataclass_fields__})
    assert type(flown(plain)) is not Orbit
    assert certify(plain).claims["stability"] == "stable"


@pytest.mark.parametrize("wrong", [None, 3, gz.pinball(), gz.stroboscopic_map(gz.pinball())])
def test_what_is_no_orbit_is_refused(wrong):
    with pytest.raises(gz.InputError, match="give a periodic orbit of an oscillator, a table or the gap map"):
        certify(wrong)


def test_a_certificate_is_saved_and_checked_from_its_file(tmp_path):
    certificate = certify(gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1])
    path = certificate.save(tmp_path / "orbit.json")
    assert json.loads(path.read_text()) == certificate.document
    assert check_certificate(path) == certificate.statement
    for part in (
        "alpha = 3.0",
        "d = 0.12",
        "(-p.r)*v + p.V",
        "exact doubles",
        "1 impact in 3 periods",
        "least period 3 T",
    ):
        assert part in certificate.statement
    assert repr(certificate) == "<Certificate: periodic orbit with 1 impact in 3 periods, proven stable>"
    assert certificate.value is None


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e6])
def test_an_orbit_that_is_another_one_than_was_given_is_told_in_any_unit(unit):
    """The numbers given are off by a hundredth or by a millionth, whatever speeds are measured in."""
    model = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.12 * unit, cos=(unit,)), gz.newton(0.8))
    orbit = next(one for one in gz.periodic_orbits(gz.stroboscopic_map(model), [1], starts=10) if one.impacts)

    def reason(share):
        other = copy(orbit)
        object.__setattr__(other, "outgoing", orbit.outgoing * (1.0 + share))
        return certify(other).reason

    assert reason(1e-6) == "" and "to another orbit" in reason(1e-2)


@pytest.mark.parametrize(("k", "said"), [(80.0, ""), (1e3, "too many time scales"), (3e4, "too many time scales")])
def test_a_stiff_spring_needs_more_digits_or_has_too_many_time_scales(k, said):
    # balls that had grown wide were taken for steps that do not shrink: "give an orbit of a smaller residual"
    forcing = gz.Forcing(2.0, offset=0.5 * k * k)
    proof = certify(without_impacts(gz.Oscillator(0.5, k, forcing, gz.newton(0.5))))
    assert said in proof.reason and proof.proven == (not said)
    if proof.proven:
        assert proof.document["data"]["precision"] > 256 and check_certificate(proof.document) == proof.statement
