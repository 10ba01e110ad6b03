"""The ladder: edges equal to closed forms and to the maps of their rungs, errors that add up, orders as derived."""

import numpy as np
import pytest

import grazing as gz
from grazing import theory
from grazing.compare.ladder import RUNGS, ladder
from grazing.maps.linearised import linearised_of
from grazing.oscillator.constants import forcing
from grazing.outcome import InputError, OutsideForm
from tests.models import packed

S = gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4)
TWO = gz.Forcing(omega=1.9, t0=0.4, offset=0.2, cos=(1.0, -0.2), sin=(0.1, 0.1))
CASES = {
    "standard": (S, "d", range(2, 9)),
    "passive": (S.replace(V=0.0), "d", range(2, 8)),
    "omega": (gz.pinball(V=0.4, sigma=0.05, d=0.17, t0=0.3), "omega", range(4, 9)),
    "two harmonics": (
        gz.Oscillator(2.5, 1.1, TWO, sigma=-0.3, reset=gz.active(r=0.7, V=0.3)),
        "offset",
        range(2, 6),
    ),
    "two, passive": (gz.Oscillator(2.5, 1.1, TWO, sigma=-0.3, reset=gz.newton(r=0.7)), "offset", range(2, 6)),
}
KNOWN = {}


def climbed(name):
    if name not in KNOWN:
        model, parameter, N = CASES[name]
        KNOWN[name] = ladder(model, parameter, N)
    return KNOWN[name]


@pytest.fixture(params=list(CASES))
def case(request):
    model, name, _N = CASES[request.param]
    return model, gz.normal_form(model, name), climbed(request.param)


def test_the_table_of_the_standard_model():
    found = climbed("standard").sel(N=slice(3, 7))
    low = [0.098450444937096, 0.121919639750295, 0.128264386287936, 0.130117517248798, 0.130689714696606]
    high = [0.123281449643921, 0.128580715549025, 0.130184992541112, 0.130703521954424, 0.130875382579699]
    assert found.edge.sel(rung="flow", side="low").values == pytest.approx(low, abs=1e-13)
    assert found.edge.sel(rung="flow", side="high").values == pytest.approx(high, abs=1e-13)
    predicted = [0.0889539502, 0.120993751428, 0.128139975581, 0.130095981315, 0.130685021777]
    assert found.edge.sel(rung="gap", side="low").values == pytest.approx(predicted, abs=1e-10)
    assert (found.type.sel(side="low") == "gr").all() and (found.type.sel(side="high") == "pd").all()
    assert (found.dip.sel(side="low") == 1).all() and (found.dip.sel(side="high") == 0).all()


def test_the_gap_map_has_the_edges_of_the_theory(case):
    _model, form, found = case
    for N in found.N.values.tolist():
        edges = [form.parameter(f(N, form.lam, form.l)) for f in (theory.mu_pd, theory.mu_bc)]
        assert found.edge.sel(rung="gap", N=N).values == pytest.approx(sorted(edges), rel=1e-14)


def test_the_flow_has_the_edges_of_its_windows(case):
    model, form, found = case
    N = found.N.values[:2].tolist()
    table = gz.windows(model.replace(**{form.name: form.graze}), form.name, N)
    for n in N:
        rows = table.sel(window=table.N == n)
        ours = found.edge.sel(rung="flow", N=n).values
        assert np.abs(np.array([rows.low.values, rows.high.values]).T - ours).sum(axis=1).min() == 0.0


def test_steps_add_up_to_the_error(case):
    *_rest, found = case
    for i in range(len(RUNGS)):
        total = found.step.isel(rung=slice(i, None)).sum("rung").values
        error = found.error.isel(rung=i).values
        known = np.isfinite(error)
        assert known.any()
        assert total[known] == pytest.approx(error[known], abs=1e-15 * np.nanmax(np.abs(found.edge.values)))


def multiplier(P, N, state):
    """The largest multiplier of the orbit through a state, by Newton's method in plain Python, and its letters."""
    c = packed(P)
    for _ in range(50):
        at, J, letters = tuple(state), np.eye(2), []
        for _n in range(N):
            at, letter, _outcome, own = P.tangent(at, c)
            J = np.array(own).reshape(2, 2) @ J
            letters.append(letter)
        step = np.linalg.solve(np.eye(2) - J, np.array(at) - state)
        state = state + step
        if np.abs(step).max() < 1e-14:
            break
    return np.linalg.eigvals(J), letters, np.array(state)


@pytest.mark.parametrize("name", ["standard", "passive", "two harmonics"])
@pytest.mark.parametrize("rung", ["linearised", "lowest", "full", "corrected"])
def test_edges_are_those_of_the_map(name, rung):
    """Settled orbits of the map inside the window: at one end the multiplier is -1, at the other a point is at 0."""
    model, parameter, _N = CASES[name]
    form, N = gz.normal_form(model, parameter), 4
    edge = climbed(name).edge.sel(rung=rung, N=N).values
    kinds = climbed(name).type.sel(rung=rung, N=N).values.tolist()
    assert sorted(kinds) == ["gr", "pd"]

    def at(share):
        value = edge[0] + share * (edge[1] - edge[0])
        if rung == "linearised":
            return linearised_of(form, value)
        return gz.discontinuity_map(model.replace(**{parameter: value}), order=rung, phase=form.time)

    middle = settled(at(0.5), np.zeros(2) if rung == "linearised" else form.from_xy(np.zeros(2)), N)
    for kind, side in zip(kinds, (0.0, 1.0), strict=True):
        state, gaps = middle, []  # follow the orbit to the edge: beside it other windows may be reached
        for k in range(1, 25):
            P = at(abs(side - 0.5**k))
            eigenvalues, letters, state = multiplier(P, N, state)
            assert letters == [1] + [0] * (N - 1)
            assert np.abs(eigenvalues).max() < 1.0
            gaps.append(1.0 + eigenvalues.real.min())
        if kind == "pd":  # the multiplier is linear in the distance from the edge, where it is -1
            assert 2.0 * gaps[-1] - gaps[-2] == pytest.approx(0.0, abs=1e-6)
            assert gaps[-1] < 1e-3
        else:
            assert border(P, rung, state, N) == pytest.approx(0.0, abs=1e-5 * abs(border(P, rung, state, 1)))


def settled(P, state, N, steps=4000):
    """A state after a long transient, turned until its letter is R."""
    c, state = packed(P), tuple(float(x) for x in state)
    for n in range(steps + N):
        new, letter = P.step(state, c)[:2]
        if n >= steps and letter == 1:
            break
        state = new
    return np.array(state)


def border(P, rung, state, N):
    """x = v^2 - 2A(u - sigma) of the point N - 1 steps after a state: the last one before the next impact."""
    c = packed(P)
    for _ in range(N - 1):
        state = P.step(tuple(state), c)[0]
    if rung == "linearised":
        return state[0]
    y, v = state[0] - c.sigma, state[1]
    return v * v - 2.0 * (forcing(0.0, c)[0] - c.alpha * v - c.k2 * y) * y


@pytest.mark.parametrize("name", list(CASES))
@pytest.mark.parametrize("side", ["low", "high"])
def test_orders_are_those_derived(name, side):
    found = climbed(name).sel(side=side)
    late = ("standard", "passive")  # only there does N go so far that what the gap map neglects shows
    for rung in list(RUNGS)[1:-1]:
        q, error, theory_ = (
            found[v].sel(rung=rung).item() for v in ("step_order", "step_order_error", "expected_step")
        )
        assert error < (0.2 if name in late else 0.6)
        assert abs(q - theory_) <= error + 0.02, (rung, q, error, theory_)
    if name == "omega":
        return  # its errors are sums of several powers, of which the least shows later than this; the steps tell
    for rung in list(RUNGS)[0 if name in late else 1 : -1]:
        q, error, theory_ = (found[v].sel(rung=rung).item() for v in ("order", "order_error", "expected"))
        assert abs(q - theory_) <= 2.0 * error + 0.05, (rung, q, error, theory_)


def test_a_window_that_the_gap_map_cannot_have():
    found = ladder(gz.pinball(alpha=0.5, k=1.0, omega=1.3, V=0.01), "d", 2)
    assert "outside (2.6): b = -0.308" in found.status.sel(rung="gap").item()
    assert found.edge.sel(rung="gap").isnull().all()
    assert found.expected.isnull().all()
    wide = ladder(gz.pinball(alpha=0.2, k=3.0, V=0.1), "d", 2, rungs=["gap"])
    assert "lambda = -0.978919" in wide.status.sel(rung="gap").item()
    assert wide.rung.values.tolist() == ["gap", "flow"]


def test_no_order_is_expected_where_the_flight_oscillates():
    found = ladder(gz.pinball(alpha=0.5, k=0.3, V=0.1), "d", range(5, 8), rungs=["linearised", "corrected"])
    assert found.attrs["lam"] ** 2 < 4.0 * found.attrs["det"]
    assert (found.status == "ok").all()
    assert found.expected.isnull().all()
    assert np.abs(found.error.sel(rung="corrected")).max() < np.abs(found.error.sel(rung="linearised")).max()


def test_period_one_has_no_far_edge_in_the_gap_map():
    found = ladder(S, "d", 1, rungs=["gap"], span=(-0.2, 0.2))
    low, high = found.edge.sel(rung="gap", N=1).values
    form = gz.normal_form(S, "d")
    assert np.isnan(low) and high == pytest.approx(form.parameter(form.l + 0.75))
    assert found.type.sel(rung="gap", N=1).values.tolist() == ["gr", "pd"]
    assert found.edge.sel(rung="flow", N=1, side="high").item() == pytest.approx(-0.00109371288517, abs=1e-13)


def test_it_can_be_saved(tmp_path):
    found = climbed("standard")
    gz.save(found, tmp_path / "ladder.nc")
    again = gz.load(tmp_path / "ladder.nc")
    assert again.edge.equals(found.edge)
    assert again.status.values.tolist() == found.status.values.tolist()


def test_what_is_refused():
    with pytest.raises(InputError, match="rung 'half' is not known; allowed are gap, linearised, lowest"):
        ladder(S, "d", rungs=["gap", "half"])
    with pytest.raises(InputError, match="N = 0; allowed is a whole number >= 1"):
        ladder(S, "d", 0)
    with pytest.raises(InputError, match="N is None; give a whole number"):
        ladder(S, "d", None)
    with pytest.raises(InputError, match="last = 2"):
        ladder(S, "d", 3, last=2)
    with pytest.raises(InputError, match="Did you mean 'omega'"):
        ladder(S, "omga")
    with pytest.raises(OutsideForm, match="the graze does not depend on V"):
        ladder(S, "V")
    with pytest.raises(OutsideForm, match="alpha = 0"):
        ladder(S.replace(alpha=0.0), "d")
    with pytest.raises(InputError, match="span of d is"):
        ladder(S, "d", 3, span=(0.2, 0.1))
