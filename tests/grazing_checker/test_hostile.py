"""Documents made to break the checker, to keep it busy, or to make it say more than it proved."""

import json
import subprocess
import sys
from time import process_time

import pytest
from flint import arb

import grazing as gz
from grazing.proof.certify import certify
from grazing_checker import Rejected, check
from grazing_checker.__main__ import main
from grazing_checker.balls import number, precision
from grazing_checker.flight import Checked, Motion, Work
from tests.grazing_checker.bases import bases
from tests.grazing_checker.documents import changed, claiming, documents
from tests.proof.orbits import closed


@pytest.mark.parametrize(
    "inside", ["1e999", "-1e999", "9" * 400 + ".0", *("[" * n + "]" * n for n in (950, 990, 5000))]
)
@pytest.mark.parametrize("field", ["data", "statement", "format", "version", "kind"])
def test_json_that_can_be_read_but_not_written_is_rejected(tmp_path, inside, field):
    document = {**documents()["free"], field: {"x": "@"} if field == "data" else "@"}
    path = tmp_path / "c.json"
    path.write_text(json.dumps(document).replace('"@"', inside))
    with pytest.raises(Rejected):
        check(path)
    assert main([str(path)]) == 1


def test_an_orbit_that_is_lifted_off_is_stable_only_if_slow_impacts_stay_slow():
    """With w = 0 a motion beside the orbit meets the wall slowly once more: a law that kicks it throws it off."""
    model = gz.Oscillator(0.3, 1.0, gz.Forcing(omega=2.2, offset=0.2, cos=(1.0,)), gz.newton(r=0.0))
    (orbit,) = gz.one_impact_orbits(model, 1)
    good = certify(orbit)
    assert good.claims["stability"] == "stable" and check(good.document) == good.statement
    fast = ["<", "v", (-0.01).hex()]
    kicking = {"parameters": {}, "after": ["if", fast, (0.0).hex(), (0.5).hex()]}
    forged = claiming(changed(good.document, ("data", "law"), lambda _old: kicking))
    with pytest.raises(Rejected, match="throw slow impacts back"):
        check(forged)
    gentle = {"parameters": {}, "after": ["if", fast, (0.0).hex(), ["*", (-0.5).hex(), "v"]]}
    other = claiming(changed(good.document, ("data", "law"), lambda _old: gentle))
    assert check(other).endswith("inside the unit circle.")
    sinking = {"parameters": {}, "after": ["if", fast, (0.0).hex(), ["*", (0.5).hex(), "v"]]}  # into the wall
    with pytest.raises(Rejected, match="throw slow impacts"):
        check(claiming(changed(good.document, ("data", "law"), lambda _old: sinking)))
    kicked = gz.reset(lambda v, p: 0.0 * v if v < -p.slow else 0.5 + 0.0 * v, slow=0.01)
    found = certify(_with(orbit, gz.Oscillator(0.3, 1.0, model.forcing, kicked)))
    assert found.proven and found.claims["stability"] == "undecided"
    assert "throw back" in found.reason and check(found.document) == found.statement


def _with(orbit, model):
    """The same numbers as an orbit of another model."""
    return closed(model, orbit.period, orbit.times, orbit.outgoing, orbit.incoming)[0]


@pytest.mark.parametrize("kind", ["pd", "gr", "lp", "ns"])
def test_a_curve_is_said_to_be_alone_nowhere_but_in_what_was_proven(kind):
    """The box printed is rounded outwards, up to 2^-30 of its size: uniqueness is proven in a smaller one."""
    statement = documents()[kind]["statement"]
    assert "alone" not in statement
    grows = {"pd": "p.V", "gr": "d", "lp": "t_1", "ns": "p.r"}[kind]
    assert f"the curve is one of such orbits in that box, along which {grows} grows, and they stay off" in statement


def test_a_value_says_no_more_than_its_multiplier_or_its_height():
    """No normal form is proven, and beyond a graze the orbits of the curve are none of the oscillator."""
    for kind in ("pd", "lp", "ns"):
        assert "(as at a " in documents()[kind]["statement"]
    free = "stay off the wall between their impacts but for that dip, in which they are continued as if there were no"
    assert free in documents()["gr"]["statement"]


def test_orbits_of_the_gap_map_that_meet_0_are_spoken_of_apart():
    """They have no multiplier: the slope of the root is infinite there."""
    statement = bases()["small"]["statement"]
    assert statement.endswith("modulus above 1, or meets 0, where the slope of its letter R is infinite.")


HOSTILE = {
    "periods": {("periods",): 10_000},
    "rates": {("model", "k"): (1e5).hex(), ("precision",): 1024},
    "impacts": {("impacts",): 900, ("claims", "box"): [["0", "0"]] * 1800},
    "slow": {("model", "omega"): (1e-5).hex()},
    "harmonics": {("periods",): 10, ("model", "cos"): [(1e-3).hex()] * 1000, ("model", "sin"): [(1e-3).hex()] * 1000},
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_certificate_that_keeps_the_checker_busy_is_rejected_before(name):
    forged = documents()["free"]
    for path, new in HOSTILE[name].items():
        forged = changed(forged, ("data", *path), lambda _old, new=new: new)
    before = process_time()
    with pytest.raises(Rejected, match="too much work"):
        check(claiming(forged))
    assert process_time() - before < 20.0


def test_work_is_counted_over_a_whole_certificate():
    work = Work()
    work.spend(work.left)
    with pytest.raises(Rejected, match="too much work"):
        work.spend(1)


@pytest.mark.parametrize("size", [-3000, -1080, 0, 900])
def test_the_bound_of_the_rest_holds_in_any_unit(size):
    """Smaller than the smallest double, all bounds are one number to a float: the largest is to be taken."""
    with precision(256):
        tiny, one = number(1, size), number(1)
        motion = Motion(one, one, one, number(0), number(0), number(0), [tiny], [number(0)], {})
        flights = Checked(motion)
        series = flights.expanded(number(0), number(0), number(0))
        assert series.C >= flights.A / flights.room
        for n in (flights.K - 2, flights.K - 1):
            size_n = abs(series.terms[n]) * arb(n + 1).gamma() / series.rho**n
            assert series.C >= size_n


def test_the_name_of_a_file_need_not_be_text(tmp_path):
    path = tmp_path / "\udcff.json"
    path.write_text(json.dumps(documents()["free"]))
    done = subprocess.run(
        [sys.executable, "-m", "grazing_checker", path],
        capture_output=True,
        text=True,
        encoding="ascii",
        errors="replace",
    )
    assert done.returncode == 0 and "For the oscillator" in done.stdout
