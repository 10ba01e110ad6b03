"""Scan and branches together: windows against closed forms, disagreements that are named, and maps of every kind."""

import numpy as np
import pytest

import grazing as gz
from grazing.compare.bifurcation_diagram import bifurcation_diagram
from grazing.orbits.branch_windows import windows_of


def windows(result):
    names = ("word", "period", "low", "high", "low_type", "high_type")
    rows = zip(*(result[f"window_{name}"].values.tolist() for name in names), strict=True)
    return {(row[0], row[1]): row[2:] for row in rows}


def kinds(result):
    return set(result["disagreement_kind"].values.tolist())


def test_the_active_wall_of_the_standard_model():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    result = bifurcation_diagram(P, "d", np.linspace(0.05, 0.16, 111), starts=30)
    found = windows(result)
    for N in range(2, 6):
        exact = gz.windows(P.model, "d", N).isel(window=0)
        low, high, low_type, high_type = found["0" * (N - 1) + "1", N]
        assert high == pytest.approx(float(exact.high), abs=1e-12) and high_type == "pd"
        if N > 2:
            assert low == pytest.approx(float(exact.low), abs=1e-12) and low_type == "gr"
    assert found["0", 1][0] == pytest.approx(gz.normal_form(P.model, "d").graze, abs=1e-14)
    unstable = (result["branch_stable"] == 0) & (result["branch_admissible"] == 1)
    assert {4, 6} <= set(result["branch_period"].values[unstable.values].tolist())
    assert not {"scan only", "not followed"} & kinds(result)


def test_the_passive_wall_joins_its_windows_by_unstable_orbits():
    P = gz.stroboscopic_map(gz.pinball(V=0.0))
    result = bifurcation_diagram(P, "d", np.linspace(0.06, 0.14, 81), starts=20)
    found = windows(result)
    assert found["01", 2][2:] == ("gr", "pd") and found["001", 3][2:] == ("gr", "pd")
    exact = gz.windows(P.model, "d", 2).isel(window=0)
    assert found["01", 2][:2] == pytest.approx((float(exact.low), float(exact.high)), abs=1e-12)
    assert "scan only" not in kinds(result)


def test_the_gap_map_with_its_windows():
    lam, l = 0.5, 0.1
    result = bifurcation_diagram(gz.gap_map(lam=lam, mu=0.05, l=l), "mu", np.linspace(0.02, 0.2, 61), starts=20)
    found = windows(result)
    checked = 0
    for N in (2, 3, 4):
        pd, bc = gz.theory.mu_pd(N, lam, l), gz.theory.mu_bc(N, lam, l)
        low, high, low_type, high_type = found["L" * (N - 1) + "R", N]
        if 0.02 < pd:
            assert (low, low_type) == (pytest.approx(pd, abs=1e-12), "pd")
            checked += 1
        if bc < 0.2:
            assert (high, high_type) == (pytest.approx(bc, abs=1e-12), "bcb")
            checked += 1
    assert checked >= 4 and "scan only" not in kinds(result)


def test_a_smooth_map_of_ones_own_and_what_lies_beyond_the_period_limit():
    def logistic(state, p):
        (x,) = state
        return (p.a * x * (1.0 - x),)

    P = gz.Map(logistic, params={"a": 3.2}, coordinates=("x",), box=((0.01, 0.99),))
    result = bifurcation_diagram(P, "a", np.linspace(2.9, 3.56, 34), starts=5, transient=2000, keep=64, period=4)
    found = windows(result)
    assert found["0", 1][1] == pytest.approx(3.0, abs=1e-9)
    assert found["0", 2][:2] == pytest.approx((3.0, 1.0 + np.sqrt(6.0)), abs=1e-8)
    rows = result["disagreement_kind"].values == "not followed"
    assert set(result["disagreement_period"].values[rows].tolist()) <= {8, 16}
    assert rows.any() and "its period is beyond 4" in result["disagreement_reason"].values[rows].tolist()


def test_a_stable_orbit_that_no_start_reaches_is_listed():
    P = gz.stroboscopic_map(gz.pinball(V=0.4, d=0.101))
    box = ((0.11, 0.12), (-0.01, 0.0))
    values = np.linspace(0.0995, 0.1025, 5)
    both = bifurcation_diagram(P, "d", values, starts=60)
    assert {("01", 2), ("001", 3)} <= set(windows(both))
    one = bifurcation_diagram(P, "d", np.concatenate([values, [0.09]]), starts=1, box=box)
    reached = set(one["word"].values.ravel().tolist())
    assert "branch only" in kinds(one) or reached == {"01", "001"}


def test_saved_and_loaded(tmp_path):
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    result = bifurcation_diagram(P, "d", np.linspace(0.09, 0.11, 5), starts=5)
    gz.save(result, tmp_path / "all.nc")
    back = gz.load(tmp_path / "all.nc")
    assert back["branch_word"].values.tolist() == result["branch_word"].values.tolist()
    drawn = gz.plot.bifurcation_diagram(back)
    assert drawn["lines"] and drawn["windows"] and drawn["provenance"]


def test_what_a_wrong_call_is_told():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    with pytest.raises(gz.InputError, match="at least 2 different"):
        bifurcation_diagram(P, "d", [0.1], starts=2)
    with pytest.raises(gz.InputError, match="period"):
        bifurcation_diagram(P, "d", [0.1, 0.11], starts=2, period=0)
    for other in (gz.impact_map(gz.pinball()), gz.stroboscopic_map(gz.pinball(), 0.3)):
        with pytest.raises(gz.InputError, match="stroboscopic map at phase 0"):
            bifurcation_diagram(other, "d", [0.1, 0.11], starts=2)
    with pytest.raises(gz.InputError, match="give the result of"):
        gz.plot.bifurcation_diagram(gz.orbit_diagram(P, "d", [0.1], starts=2))


def undamped():
    """An undamped oscillator, whose grazes begin pieces with ever more impacts."""
    return gz.Oscillator(alpha=0, k=1, forcing=gz.Forcing(omega=2.5, cos=(1,)), sigma=0, reset=gz.newton(0.8))


def test_following_has_a_limit_that_is_said_and_shows_how_far_it_is():
    seen = []
    P, values = gz.stroboscopic_map(undamped()), np.linspace(1.5, 4.0, 9)
    result = bifurcation_diagram(P, "omega", values, starts=10, points=400, progress=lambda *done: seen.append(done))
    assert result.sizes["branch_point"] <= 400 + 10  # an event takes a point of its own
    assert "the limit of 400 points in all" in result.attrs["unfinished"]
    rows = result["disagreement_kind"].values == "not followed"
    assert "the limit of 400 points was reached" in result["disagreement_reason"].values[rows].tolist()
    assert result["branch_period"].values[0] == 1  # short ones first
    counted = [done for done, total in seen if total == 400]
    assert (9, 9) in seen and len(counted) > 1 and counted == sorted(counted)
    assert "unfinished" not in bifurcation_diagram(P, "omega", [3.4, 3.5], starts=5, period=2).attrs


def test_a_response_says_what_its_limit_cuts_off():
    result = gz.response(gz.stroboscopic_map(undamped()), "omega", np.linspace(1.5, 4.0, 5), starts=5, points=50)
    assert "the limit of 50 points in all" in result.attrs["unfinished"]


def test_the_orbit_without_impacts_is_followed_though_no_start_reaches_it():
    model = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=3.0, cos=(1,)), sigma=-0.2, reset=gz.newton(0.8))
    P, values = gz.stroboscopic_map(model), [2.4, 2.9, 3.1, 3.2]
    inside = ((0.0, 0.001), (2.0, 2.001))  # all starts go to the orbit with impacts
    result = bifurcation_diagram(P, "omega", values, starts=1, period=4, box=inside)
    assert "0" not in result.word.values.ravel().tolist()
    # the amplitude 1/|k^2 - omega^2 + i alpha omega| is 0.2 at the graze
    root = np.roots([1.0, 0.0, 0.1**2 - 2.0, 0.0, 1.0 - 1.0 / 0.2**2])
    graze = float(max(root[abs(root.imag) < 1e-9].real))
    low, high, low_type, _high_type = windows(result)["0", 1]
    assert (low, high) == pytest.approx((graze, 3.2), abs=1e-9) and low_type == "gr"
    rows = result.disagreement_word.values == "0"
    assert result.disagreement_kind.values[rows].tolist() == ["branch only"]
    found = gz.response(P, "omega", values, starts=[[0.0, 2.0]])
    assert "0" in found.branch_word.values.tolist()


def rig(omega):
    """A mass of 2 on a spring of stiffness 8 and a damper of 0.8, shaken by a force of amplitude 1, a stop at 0.3."""
    return gz.Oscillator.from_si(
        m=2.0, c=0.8, k=8.0, force=1.0, gap=0.3, side="above", frequency=omega / (2.0 * np.pi), reset=gz.newton(0.8)
    )


def rig_grazes(omega):
    """Whether the steady response has the amplitude 0.3 of the stop, to rounding."""
    return 1.0 / np.hypot(8.0 - 2.0 * omega**2, 0.8 * omega) == pytest.approx(0.3, rel=1e-12)


@pytest.fixture(scope="module")
def doubled():
    """The branch of the rig that begins at the period doubling of its orbit with an impact a period."""
    (orbit,) = (one for one in gz.one_impact_orbits(rig(2.5), 1) if one.stable and one.admissible)
    P = gz.stroboscopic_map(rig(2.5))
    branch = gz.continuation(P, orbit, "omega", (1.5, 3.5))
    (pd,) = (one for one in branch.special if one.type == "pd" and one.admissible)
    return gz.continuation(P.replace(omega=pd.value), pd, "omega", (1.5, 3.5))


def window_of(branch, word):
    (found,) = (one for one in windows_of(branch) if one.word == word)
    return found


def test_a_window_ends_at_its_special_point_where_a_loop_is_begun_at_a_graze(doubled):
    loop = doubled.pieces[1]
    assert loop.ends == ("closed", "closed") and {0, len(loop.orbits) - 1} <= set(loop.events)
    found = window_of(doubled, "01")
    values = {one.type: one.value for one in doubled.special if one.piece == 1 and one.admissible}
    graze = doubled.special[0]
    assert (found.low_type, found.high_type) == ("lp", "gr") == ("lp", graze.type)
    assert (found.low, found.high) == pytest.approx((values["lp"], graze.value), abs=1e-12)
    for beside, there in ((found.high - 1e-6, True), (found.high + 1e-6, False)):
        assert any(one.stable and one.admissible and one.word == "01" for one in doubled.at(beside)) == there


def test_a_window_is_not_cut_where_a_loop_was_begun(doubled):
    (begun,) = (one for one in doubled.at(1.7) if one.stable and one.admissible)
    P = gz.stroboscopic_map(rig(1.7))
    again = gz.continuation(P, begun, "omega", (1.5, 3.5))
    assert again.pieces[0].ends == ("closed", "closed") and 0 not in again.pieces[0].events
    one, other = window_of(again, "01"), window_of(doubled, "01")
    assert (one.low_type, one.high_type) == ("lp", "gr")
    assert (one.low, one.high) == pytest.approx((other.low, other.high), abs=1e-12)


def test_a_graze_in_each_of_two_periods_is_one_special_point(doubled):
    met = [one for one in doubled.special if one.piece == 1 and rig_grazes(one.value)]
    assert [one.value for one in met] == pytest.approx([1.5670669664553445, 2.320409688534429], abs=1e-12)
    assert all(one.type == "gr" and one.converged for one in met)
    assert [doubled.pieces[one.to].orbits[0].word for one in met] == ["0", "0"]


def test_a_stable_orbit_on_several_branches_is_one_disagreement():
    values = [1.5, 1.6, 1.88, 2.35, 2.4, 2.5]
    inside = ((0.0, 0.001), (0.0, 0.001))  # all starts go to orbits with impacts
    result = bifurcation_diagram(gz.stroboscopic_map(rig(2.5)), "omega", values, starts=1, period=2, box=inside)
    lone = [result[f"disagreement_{key}"].values.tolist() for key in ("kind", "word", "low", "high", "reason")]
    rows = list(zip(*lone, strict=True))
    assert len(set(rows)) == len(rows) and ("branch only", "0", 2.35, 2.4) in {row[:4] for row in rows}
    pieces = result.branch_piece.values[(result.branch_word.values == "0") & (result.branch_omega.values > 2.4)]
    assert len(set(pieces.tolist())) > 1


def nordmark():
    """The map of Chin et al. (1994)."""
    return gz.Map(
        pieces={
            "L": lambda s, p: (p.alpha * s[0] + s[1] + p.rho, -p.gamma * s[0]),
            "R": lambda s, p, root: (-root + s[1] + p.rho, -p.gamma * p.tau**2 * s[0]),
        },
        border=lambda s, p: s[0],
        params={"alpha": 0.5, "gamma": 0.05, "tau": 0.8, "rho": 0.15},
        coordinates=("x", "y"),
        box=((-0.5, 0.5), (-0.1, 0.1)),
    )


def test_an_orbit_that_still_settles_beside_its_period_doubling_lies_on_its_branch():
    P = nordmark()
    a, c, t = P.params["alpha"], P.params["gamma"], P.params["gamma"] * P.params["tau"] ** 2
    s = 0.5 * a / ((1.0 - c) * (1.0 - t))  # 1 + tr + det = 0, s the root of x at R
    doubling = (s * s * (1.0 + t) * (1.0 + c) + a * s) / (1.0 + c + a)
    result = bifurcation_diagram(P, "rho", [0.138, 0.14, 0.16], starts=5)
    assert windows(result)["LR", 2][::2] == (pytest.approx(doubling, abs=1e-12), "pd")
    assert "not followed" not in kinds(result)
    alone = bifurcation_diagram(P, "rho", [0.1398, 0.14], starts=5, transient=50)  # at neither value one has settled
    assert alone.disagreement_kind.values.tolist() == ["not followed"]
    (reason,) = alone.disagreement_reason.values
    assert reason.startswith("its points after 98 steps are not yet those of a periodic orbit, as near a bifurcation")


def test_a_neutral_motion_is_named_and_not_taken_for_one_that_has_not_settled():
    walls = (gz.wall(-1.0, gz.newton(0.6)), gz.wall(1.0, gz.newton(0.6)))
    rattle = gz.Oscillator(alpha=0.1, k=0.0, forcing=gz.Forcing(omega=1.0, cos=(0.2,)), walls=walls)
    result = bifurcation_diagram(gz.stroboscopic_map(rattle), "cos1", [0.1, 0.2], starts=4, period=1)
    (row,) = np.flatnonzero(result.disagreement_word.values == "0")
    assert result.disagreement_kind.values[row] == "not followed"
    assert result.disagreement_reason.values[row].startswith("it is neutral, one of a continuum of orbits")


def test_between_walls_too_it_is_seen_where_its_branches_are():
    law = gz.newton(0.8)
    pair = gz.Oscillator(0.1, 1.0, gz.Forcing(omega=0.8), walls=(gz.wall(-0.5, law), gz.wall(0.5, law)))
    with pytest.raises(gz.InputError, match="points of its stroboscopic map at phase 0"):
        gz.bifurcation_diagram(gz.stroboscopic_map(pair, phase=0.7), "omega", [0.7, 0.8])
