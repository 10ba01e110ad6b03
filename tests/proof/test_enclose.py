from fractions import Fraction
from time import process_time

import pytest

import grazing as gz
from grazing.orbits.windows import windows
from grazing.proof.check import check_certificate
from grazing.proof.enclose import enclose
from grazing_checker.sentence import EVENTS
from tests.models import TWO_HARMONICS
from tests.proof.orbits import without_impacts


def edges(model, name, N, **more):
    """Every edge of the windows of a model that can be enclosed, with an orbit a tenth inside the window."""
    found = windows(model, name, N=N, **more)
    for i in range(found.sizes["window"]):
        row = found.isel(window=i)
        low, high = float(row.low), float(row.high)
        for kind, edge, other in ((row.low_type.item(), low, high), (row.high_type.item(), high, low)):
            if kind in ("pd", "lp", "ns", "gr"):
                inside = model.replace(**{name: edge + 0.1 * (other - edge)})
                orbits = [o for o in gz.one_impact_orbits(inside, int(row.N)) if o.admissible and o.stable]
                yield kind, edge, orbits


def checked(certificate):
    assert certificate.proven, certificate.reason
    assert check_certificate(certificate.document) == certificate.statement
    return certificate


def test_the_edges_of_the_windows_of_the_standard_model_are_enclosed_in_time():
    count = 0
    for kind, edge, orbits in edges(gz.pinball(V=0.4), "d", (2, 4, 7)):
        (orbit,) = orbits
        start = process_time()
        certificate = enclose(orbit, kind, "d")
        assert process_time() - start < 2.0
        low, high = checked(certificate).value
        assert low <= edge <= high
        assert high - low <= 1e-12
        count += 1
    assert count == 6


@pytest.mark.parametrize(
    ("model", "name", "N", "kinds"),
    [
        (gz.pinball(alpha=0.2, omega=2.8, V=0.0, d=0.0), "d", [1, 2], {"lp", "pd"}),
        (gz.pinball(alpha=0.05, d=-0.5), "d", [1], {"lp", "ns"}),
        (TWO_HARMONICS, "omega", [1], {"lp", "gr"}),
        (gz.pinball(alpha=2.0, V=0.3, r=0.9, d=-0.2), "d", [2, 3], {"gr", "pd"}),
        (gz.pinball(d=0.1), "sigma", [2], {"gr", "pd"}),
        (gz.pinball(d=0.12), "k", [3], {"gr", "pd"}),
        (gz.pinball(d=0.1), "V", [2, 3], {"gr", "pd"}),
        (gz.pinball(d=0.12), "alpha", [2, 3], {"gr", "pd"}),
        (gz.pinball(d=0.12), "cos1", [3], {"gr", "pd"}),
        (gz.pinball(alpha=0.05, d=0.1), "r", [1], {"ns"}),
        (gz.pinball(d=0.1), "r", [3], {"gr"}),
        (gz.pinball(alpha=0.05, d=0.1), "omega", [1, 2], {"ns", "lp", "pd"}),
    ],
)
def test_edges_of_other_models_and_parameters_are_enclosed(model, name, N, kinds):
    seen = set()
    for kind, edge, orbits in edges(model, name, N):
        for orbit in orbits:
            low, high = checked(enclose(orbit, kind, name)).value
            seen.add(kind)
            assert low - 1e-13 <= edge <= high + 1e-13
            assert high - low <= 1e-12
    assert kinds <= seen


def test_the_graze_of_the_steady_response_has_its_closed_form():
    model = gz.pinball(d=0.14)
    certificate = checked(enclose(without_impacts(model), "gr", "d"))
    low, high = certificate.value
    assert low <= gz.normal_form(model, "d").graze <= high
    assert high - low <= 1e-12
    assert "touches the wall" in certificate.statement


#: An orbit with a fold, where the parameter determines no orbit, and with grazes at which its impact has no speed.
RIG = gz.Oscillator(alpha=0.4, k=2.0, forcing=gz.Forcing(omega=2.5, cos=(0.5,)), sigma=-0.3, reset=gz.newton(0.8))


@pytest.mark.parametrize(
    ("model", "N", "name", "bounds", "kinds"),
    [
        (RIG, 1, "omega", (1.5, 2.9), {"lp", "gr", "pd"}),
        (gz.pinball(d=0.11, V=0.4), 3, "d", (0.09, 0.13), {"gr", "pd"}),
    ],
)
def test_the_orbit_of_a_special_point_will_do(model, N, name, bounds, kinds):
    (orbit,) = (one for one in gz.one_impact_orbits(model, N) if one.stable and one.admissible)
    seen = set()
    for one in gz.continuation(orbit.map, orbit, name, bounds).special:
        if not one.admissible or one.type not in EVENTS:
            continue
        certificate = checked(enclose(one.orbit, one.type, name))
        low, high = certificate.value
        seen.add(one.type)
        assert low - 1e-13 <= one.value <= high + 1e-13 and high - low <= 1e-12
        if one.type == "gr" and model is RIG:  # the orbit without the impact that has lost its speed
            assert one.orbit.impacts == 1 and certificate.document["data"]["impacts"] == 0
            assert low <= gz.normal_form(one.orbit.model, name).graze <= high
    assert seen == kinds


def test_a_bifurcation_that_is_not_there_is_not_found():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    for kind, name in (("ns", "omega"), ("lp", "t0"), ("pd", "t0"), ("gr", "t0")):
        certificate = enclose(orbit, kind, name)
        assert not certificate.proven and certificate.value is None
        assert "give an orbit nearer" in certificate.reason or "give one nearer" in certificate.reason


@pytest.mark.parametrize(("alpha", "r", "d", "N"), [(0.05, 0.74, -0.26, 2), (0.05, 0.72, -0.485, 1)])
def test_the_bifurcation_of_another_branch_is_not_that_of_the_orbit(alpha, r, d, N):
    """Without stiffness two orbits have one velocity, far from each other in time: one of them doubles."""
    model = gz.pinball(alpha=alpha, k=0, omega=2, d=d, r=r, V=0.4)
    doubles, other = (one for one in gz.one_impact_orbits(model, N) if one.admissible)
    low, high = checked(enclose(doubles, "pd", "omega")).value
    near = gz.one_impact_orbits(model.replace(omega=(low + high) / 2), N)
    off = [min(abs(one.multipliers + 1)) for one in near]
    assert len(near) == 2 and min(off) < 1e-9 and max(off) > 0.9
    certificate = enclose(other, "pd", "omega")
    assert not certificate.proven and "nearer to it" in certificate.reason


def test_real_multipliers_whose_product_is_1_are_no_pair_on_the_unit_circle():
    model = gz.pinball(alpha=0.05, k=1, omega=1.1, d=0.12, r=0.9, V=0.4)
    (orbit,) = (one for one in gz.one_impact_orbits(model, 1) if one.admissible and one.multipliers[0].real < -1.5)
    proof = enclose(orbit, "ns", "V")
    assert not proof.proven and "two real multipliers have the product 1 there, a neutral saddle" in proof.reason


def test_a_bifurcation_of_a_virtual_orbit_is_refused():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    certificate = enclose(orbit, "lp", "sigma")
    assert not certificate.proven and "virtual" in certificate.reason


def test_an_orbit_without_impacts_has_a_graze_only():
    certificate = enclose(without_impacts(gz.pinball(d=0.14)), "pd", "d")
    assert not certificate.proven and "it has a graze only" in certificate.reason


def test_wrong_questions_are_refused_by_name():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    with pytest.raises(gz.InputError, match="allowed are pd, lp, ns, gr"):
        enclose(orbit, "hopf", "d")
    with pytest.raises(gz.InputError, match="unknown parameter 'D'"):
        enclose(orbit, "pd", "D")
    with pytest.raises(gz.InputError, match="give a periodic orbit"):
        enclose(3, "pd", "d")
    (of_gap,) = gz.periodic_orbits(gz.gap_map(0.5, 0.1, 0.2), 2)
    for kind, name, said in (([], "mu", r"kind is \[\]"), ("pd", [1], r"name is \[1\]")):
        with pytest.raises(gz.InputError, match=said):
            enclose(of_gap, kind, name)


def test_the_certificate_says_what_it_encloses():
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    certificate = enclose(orbit, "pd", "d")
    low, high = certificate.claims["value"]
    assert f"there is a value of d in [{low}, {high}]" in certificate.statement
    assert "d = 0.12," not in certificate.statement
    assert "(as at a period doubling)" in certificate.statement
    assert "it is asymptotically stable, at the second: it is unstable" in certificate.statement
    assert "d = 0.123281449643921 to within" in repr(certificate)
    middle, reach = (Fraction(part.rstrip(">")) for part in repr(certificate).split("d = ")[1].split(" to within "))
    assert middle - reach <= Fraction(low) and Fraction(high) <= middle + reach  # no less than what is proven


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e6])
def test_an_enclosure_is_as_narrow_in_any_unit_of_length(unit):
    """In nanometres all windows once lay in one enclosure."""
    force = gz.Forcing(omega=2.0, offset=0.1 * unit, cos=(unit,))
    ball = gz.Oscillator(alpha=3.0, k=1.0, forcing=force, reset=gz.active(r=0.8, V=0.4 * unit))
    proofs = [
        (edge, enclose(orbit, kind, "offset")) for kind, edge, (orbit,) in edges(ball, "offset", [2], samples=200)
    ]
    assert len(proofs) == 2
    for edge, proof in proofs:
        low, high = checked(proof).value
        assert low <= edge <= high and high - low < 1e-12 * unit
