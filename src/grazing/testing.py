"""Laws that every map and every model must keep: for what we ship, and for yours.

``check_map`` and ``check_model`` raise AssertionError with the law that failed and the state at which it did.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.check import check as check_flights
from grazing.billiard.table import Table
from grazing.maps.collisions import checked_table
from grazing.maps.hits import Hits
from grazing.maps.impact import impact_map
from grazing.maps.map import CHATTER_LETTER, Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.constants import constants_of, forcing, section_phase
from grazing.oscillator.exact import exact_period
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.reset import checked_velocity
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import AMBIGUOUS, CHATTER, FATAL, GRAZE, STUCK, InputError, UserCodeError, shown, told
from grazing.parameter import parameters, whole
from grazing.studies.starts import checked_seed
from grazing.systems.check import check
from grazing.systems.contract import System

#: Outcomes at which a map need not be smooth.
_ROUGH = FATAL | AMBIGUOUS | GRAZE | STUCK


def check_map(P: Map, states: int = 24, steps: int = 12, seed: int = 0) -> None:
    """Hold a map to the laws of the protocol.

    Parameters
    ----------
    P : Map
        Any map; states are drawn from its box.
    states : int
        How many.
    steps : int
        How far each is followed.
    seed : int

    Raises
    ------
    AssertionError
        Names the law and the state. The laws: compiled code gives the bits of the plain Python step; n steps are n
        times one step; results do not depend on how many orbits run side by side; ``replace`` keeps what it does
        not change; the Jacobian agrees with central differences wherever the letter is locally constant; pieces give
        the bits of the step, and borders choose its letter; a ``block``
        twin makes the decisions of the step, within four units in the last place a period, and its bits depend
        neither on threads nor on the size of a block.
    UserCodeError
        For a step that raises, or a reset law that raises or returns what it must not, in one of these steps.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.testing.check_map(gz.gap_map(lam=0.5, mu=0.1, l=0.2))
    """
    if not isinstance(P, Map):
        raise InputError(f"P is {shown(P)}; give a map, such as gz.stroboscopic_map(model); models go to check_model")
    states, steps, seed = whole(states, "states", 1), whole(steps, "steps", 1), checked_seed(seed)
    starts = _starts(P, states, seed)
    _check_law(P, starts, steps)
    _check_bits(P, starts, steps)
    _check_lanes(P, starts, steps)
    again = P.replace(**P.params)
    assert dict(again.params) == dict(P.params), f"{P.name}: replace() with the same values changed the parameters"
    assert _equal(again.iterate(starts[0], steps), P.iterate(starts[0], steps)), f"{P.name}: replace() changed the map"
    for start in starts:
        _check_jacobian(P, start)
    if P.formulas is not None:
        _check_pieces(P, starts)
    if P.origin.block is not None:
        _check_block(P, starts, steps)


def check_model(model: Oscillator, states: int = 12, periods: int = 12, seed: int = 0) -> None:
    """Hold a model to the laws of motion.

    Parameters
    ----------
    model : Oscillator
    states : int
        Random starts.
    periods : int
        How long each is followed.
    seed : int

    Raises
    ------
    AssertionError
        Names the law and the start. The laws: the ball is never inside the wall; every impact is at the wall, moves
        towards it before and away after, as the reset law says; between impacts the equation of motion holds;
        the stroboscopic map and the trajectory agree; so do the impact map and the list of impacts; both section
        maps keep the laws of :func:`check_map`; no impact is missed or invented beside grazes built on purpose, as
        ball arithmetic says.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.testing.check_model(gz.pinball(d=0.1), states=3)
    """
    checked_model(model)
    P, Q = stroboscopic_map(model), impact_map(model)
    check_map(P, states, min(periods, 6), seed)
    check_map(Q, states, 3, seed)
    _check_grazes(model, P, 4 * states, seed)
    for start in _starts(P, states, seed):
        flown = trajectory(model, start, until=periods * model.period)
        said = f"{model!r}, start {start.tolist()}"
        assert float(flown.u.min()) >= model.sigma, f"{said}: the ball is inside the wall, u = {float(flown.u.min())}"
        _check_impacts(model, flown, said)
        _check_motion(model, flown, said)
        orbit = P.orbit(start, periods)
        if not np.bitwise_or.reduce(orbit.outcomes) & _ROUGH:
            end = np.array([flown.u.values[-1], flown.v.values[-1]])
            grown = np.abs(orbit.points).max() + 1.0
            for i in range(periods):
                grown *= max(1.0, float(np.linalg.norm(P.jacobian(orbit.points[i]), 2)))
            error = float(np.abs(end - orbit.points[-1]).max())
            assert error <= 1e-13 * grown, f"{said}: trajectory and stroboscopic map differ by {error:.1e}"
            _check_returns(model, Q, flown, said)


def check_system(system: System, states: int = 8, seed: int = 0) -> None:
    """Hold a system of your own to what its functions promise.

    Parameters
    ----------
    system : System
    states : int
        Random states of its box that are tried.
    seed : int

    Raises
    ------
    AssertionError
        Names the promise, with a counterexample. The promises, in ball arithmetic of 500 bits: a flight is made of its
        halves, velocities are the rates of positions, and all repeats itself after the period; ``dh`` is the rate of
        the gap; abs(h'') is within the bound at many places of random intervals; gap and rate are computed with no more
        than the errors that are said. A dense search finds no impact that was missed, laws leave the surface and do not
        move away from it, and near grazes, built on purpose, none is missed or invented.
    UserCodeError
        For a function that raises, or cannot work in ball arithmetic.

    Examples
    --------
    >>> import grazing as gz
    >>> def flight(t, t0, state, p):
    ...     x, v = state
    ...     return x + v * (t - t0), v
    >>> def gap(t, state, p):
    ...     return 1.0 - state[0], state[1]
    >>> def bound(t, w, state, p):
    ...     return 0.0
    >>> wall = gz.Surface("A", gap, bound)
    >>> wrong = gz.System(("x",), ("v",), {"r": 1.0}, flight, [wall], box=((0.0, 1.0), (0.5, 1.0)))
    >>> gz.testing.check_system(wrong)
    Traceback (most recent call last):
    AssertionError: along the flight from ... the gap of surface A changes at -0.63..., but says dh = 0.63...
    """
    if not isinstance(system, System):
        raise InputError(f"system is {shown(system)}; give a gz.System, models go to check_model and maps to check_map")
    check(system, whole(states, "states", 1), checked_seed(seed))


def check_table(table: Table, states: int = 8, seed: int = 0) -> None:
    """Check a pinball table: every impact is found, by exact algebra and a dense search, and does what its law says.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    states : int
        Random starts; forty flights of each are looked at.
    seed : int

    Raises
    ------
    AssertionError
        For the first thing that is wrong, with the flight.
    InputError
        If a ball of its radius fits nowhere among the objects.
    UserCodeError
        If a law raises, or returns what it must not.

    Examples
    --------
    >>> import grazing as gz
    >>> discs = [gz.disc(name, (x, 0), 1.0, gz.newton(1.0)) for name, x in (("A", 0), ("B", 3))]
    >>> gz.testing.check_table(gz.table(discs, rho=0.2), states=2)
    """
    check_flights(checked_table(table), whole(states, "states", 1), checked_seed(seed))


def _starts(P: Map, n: int, seed: int) -> NDArray[np.float64]:
    box = np.array(P.box)
    return np.random.default_rng(seed).uniform(box[:, 0], box[:, 1], (n, P.dimension))


def _equal(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))


def _check_law(P: Map, starts: NDArray[np.float64], steps: int) -> None:
    """Raise what would be warned of: with a law that breaks its promise nothing further holds."""
    lanes = np.ascontiguousarray(starts.T)[None]
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            P.run_columns(P.packed()[1], lanes, 0, steps, threads=1)
        except RuntimeWarning as said:
            raise UserCodeError(str(said)) from None


def _check_bits(P: Map, starts: NDArray[np.float64], steps: int) -> None:
    p = parameters(P.params)
    c = P.prepare(p) if P.prepare is not None else p
    for start in starts:
        orbit = P.orbit(start, steps)
        state: Any = tuple(start.tolist())
        for i in range(steps):
            try:
                state, letter, outcome = P._full_step(state, c)
            except Exception as error:
                raise UserCodeError(f"{P.name}: in plain Python the step from {state} raised {told(error)}") from error
            said = f"{P.name}: compiled and plain step differ at step {i + 1} from {start.tolist()}"
            assert _equal(np.array(state, dtype=np.float64), orbit.points[i + 1]), said
            assert letter == orbit.letters[i], said
            if outcome & FATAL or not np.isfinite(state).all():
                break
            assert outcome == orbit.outcomes[i], said


def _check_lanes(P: Map, starts: NDArray[np.float64], steps: int) -> None:
    many = np.repeat(starts, 6, axis=0).T.copy()  # more than one block, and a rest
    points, letters, _outcomes = P.run(many, 0, steps)
    for i, start in enumerate(starts):
        alone = P.orbit(start, steps)
        said = f"{P.name}: the orbit from {start.tolist()} depends on its neighbours"
        for copy in (6 * i, 6 * i + 5):
            assert _equal(points[:, :, copy], alone.points[1:]), said
            assert _equal(letters[:, copy], alone.letters), said


def _check_pieces(P: Map, starts: NDArray[np.float64]) -> None:
    """Hold the pieces of a map, which orbits are followed by, to its step."""
    images, row = P.images(), P.packed()[1][None]
    ran = [P.orbit(start, 1) for start in starts]
    letters = np.array([int(one.letters[0]) for one in ran])
    borders = images(row, 0, starts, letters, 0.0)[1]
    for i, k in enumerate(letters):
        own = int(np.argmax(borders[i] < 0.0)) if (borders[i] < 0.0).any() else borders.shape[1]
        assert own == k, f"{P.name}: at {starts[i].tolist()} the borders choose piece {own}, the step letter {k}"
    found = images(row, 0, starts, letters, np.sqrt(np.abs(borders[:, 0])))[0]
    for start, one, image in zip(starts, ran, found, strict=True):
        if one.outcomes[0] & FATAL == 0:
            assert _equal(image, one.points[1]), f"{P.name}: piece and step differ at {start.tolist()}"


def _check_jacobian(P: Map, start: NDArray[np.float64]) -> None:
    if P.tangent is None:
        return
    slopes = P.jacobian(start)
    h = 2e-5 * np.maximum(1.0, np.abs(start))
    near = [P.orbit(start + sign * np.diag(h)[i], 1) for i in range(P.dimension) for sign in (-1.0, 1.0)]
    here = P.orbit(start, 1)
    rough = any(one.outcomes[0] & _ROUGH or one.letters[0] != here.letters[0] for one in [here, *near])
    if rough or not np.isfinite(slopes).all():
        return
    # a second difference measures how far the central difference can be trusted
    columns, bends = [], []
    for i in range(P.dimension):
        low, high = near[2 * i].points[1], near[2 * i + 1].points[1]
        columns.append((high - low) / (2.0 * h[i]))
        bends.append(np.abs(high - 2.0 * here.points[1] + low) / h[i])
    differences, bend = np.array(columns).T, np.array(bends).T
    allowed = 1e-6 * (1.0 + np.abs(slopes).max()) + bend
    wrong = np.abs(differences - slopes) > allowed
    assert not wrong.any(), (
        f"{P.name}: Jacobian {slopes.tolist()} at {start.tolist()}, central differences {differences.tolist()}"
    )


def _check_block(P: Map, starts: NDArray[np.float64], steps: int) -> None:
    """Hold the block to the scalar step: the same decisions, rounding apart; the same bits in any company."""
    row = np.array(list(P.params.values()))[None]
    path = [P.orbit(start, steps) for start in starts]
    states = np.concatenate([orbit.points[:-1] for orbit in path]).T
    states = np.ascontiguousarray(states[:, np.isfinite(states).all(axis=0)])
    one = P.run_columns(row, states[None].copy(), 0, 1, arithmetic="strict", algorithm="scalar", threads=1)
    constants = P.prepare(parameters(P.params)) if P.prepare is not None else None
    seen = getattr(constants, "a", constants)  # between walls: as the first one sees the ball
    scale = np.abs(states).max() + np.nanmax(np.abs(one.points), initial=getattr(seen, "size", 0.0))
    for arithmetic in ("strict", "fast"):
        two = P.run_columns(row, states[None].copy(), 0, 1, arithmetic=arithmetic, algorithm="block", threads=1)
        for i, state in enumerate(states.T):
            said = f"{P.name}: from {state.tolist()} the block ({arithmetic}) differs from the scalar step"
            assert two.letters[0, 0, i] == one.letters[0, 0, i], f"{said}: letters {two.letters[0, 0, i]}"
            assert two.outcomes[0, 0, i] == one.outcomes[0, 0, i], f"{said}: outcomes {two.outcomes[0, 0, i]}"
            if one.outcomes[0, 0, i] & _ROUGH:
                continue
            slopes = P.jacobian(state)
            grown = max(1.0, float(np.abs(slopes).max())) if np.isfinite(slopes).all() else np.inf
            error = float(np.abs(two.points[0, 0, :, i] - one.points[0, 0, :, i]).max())
            letter = max(0, int(one.letters[0, 0, i]))
            flights = 1 + (len(P.letters.symbol(letter)) if isinstance(P.letters, Hits) else letter)
            assert error <= 4.0 * 2.0**-52 * flights * scale * grown, f"{said} by {error:.1e}"
    _check_company(P, row, states, steps)


def _check_company(P: Map, row: NDArray[np.float64], states: NDArray[np.float64], steps: int) -> None:
    """Bits must not depend on threads, on the size of a block or on what else is in it."""
    n = states.shape[1]
    alone = P.run_columns(row, states[None].copy(), 1, steps, threads=1)
    many = np.stack([np.tile(states, (1, -(-700 // n))), np.tile(states[:, ::-1], (1, -(-700 // n)))])
    for threads in (1, 2):
        crowd = P.run_columns(np.repeat(row, 2, axis=0), many.copy(), 1, steps, threads=threads)
        said = f"{P.name}: with {threads} thread(s) and other orbits beside it an orbit has other bits"
        for q, order in enumerate((slice(None), slice(None, None, -1))):
            for first in (0, n * (700 // n - 1)):
                part = slice(first, first + n)
                assert _equal(crowd.points[q, :, :, part], alone.points[0][:, :, order]), said
                assert _equal(crowd.letters[q, :, part], alone.letters[0][:, order]), said


def _check_grazes(model: Oscillator, P: Map, count: int, seed: int) -> None:
    """Build flights that touch the wall, a little above or below it, and compare every path with ball arithmetic."""
    random = np.random.default_rng(seed)
    row = np.array(list(P.params.values()))[None]
    for _ in range(count):
        start = _grazing_start(model, random, 10.0 ** -random.uniform(2.0, 12.0) * random.choice((-1.0, 1.0)))
        truth = None if start is None else exact_period(model, start)
        if start is None or truth is None or truth.outcome & _ROUGH:
            continue
        letter = CHATTER_LETTER if truth.outcome & CHATTER else truth.impacts
        for algorithm in ("block", "scalar"):
            lanes = np.array(start).reshape(1, 2, 1)
            found = P.run_columns(row, lanes, 0, 1, algorithm=algorithm, threads=1)
            said = f"{model!r}: from {start} ({algorithm})"
            assert found.letters[0, 0, 0] == letter, (
                f"{said} {found.letters[0, 0, 0]} impacts instead of {letter}, nearest miss {truth.near:.1e}"
            )
            slopes = P.jacobian(start)
            grown = max(1.0, float(np.abs(slopes).max())) if np.isfinite(slopes).all() else np.inf
            error = float(np.abs(found.points[0, 0, :, 0] - np.array(truth.state)).max())
            scale = np.abs(start).max() + np.abs(truth.state).max() + abs(model.sigma)
            assert error <= 1e-13 * (scale + 1.0) * grown, f"{said} the state is {error:.1e} off"


def _grazing_start(model: Oscillator, random: np.random.Generator, height: float) -> tuple[float, float] | None:
    """Return a state at t = 0 whose free flight turns at this height above the wall; None if it starts in the wall."""
    p = parameters({**model.params, "phase": 0.0})
    c = constants_of(model.harmonics, section_phase)(p)
    t = c.T * random.uniform(0.05, 0.95)
    F, _dF = forcing(t, c)
    if F <= 0.0:
        return None
    E = np.array(modes(t, c)).reshape(2, 2)
    y, v = flight(t, anchored(0.0, 0.0, 0.0, c), c)
    if not abs(np.linalg.det(E)) > 1e-30:
        return None
    start = np.linalg.solve(E, np.array([height - y, -v]))
    if not np.abs(start).max() < 1e6 * c.size or start[0] < 0.0:
        return None
    return float(start[0] + model.sigma), float(start[1])


def _check_impacts(model: Oscillator, flown: Any, said: str) -> None:
    times, before, after = flown.impact_time.values, flown.v_minus.values, flown.v_plus.values
    assert (np.diff(times) >= 0.0).all(), f"{said}: impacts out of order"
    assert (before <= 0.0).all(), f"{said}: an impact moves away from the wall"
    for v, w in zip(before, after, strict=True):
        if w > 0.0:  # 0 stands for the rest that ends a chatter
            expected = checked_velocity(model.reset, float(v), model.reset.params)
            assert w == expected, f"{said}: v_minus = {v} left with {w}, the law says {expected}"


def _check_motion(model: Oscillator, flown: Any, said: str) -> None:
    t, u, v = flown.t.values, flown.u.values, flown.v.values
    f, forcing = np.full_like(t, model.forcing.offset), model.forcing
    for j, (c, s) in enumerate(zip(forcing.cos, forcing.sin, strict=True), start=1):
        angle = j * forcing.omega * (t + forcing.t0)
        f += c * np.cos(angle) + s * np.sin(angle)
    a = f - model.alpha * v - model.k2 * u
    dt = np.diff(t)
    flying = (dt > 0.0) & (np.maximum(u[1:], u[:-1]) > model.sigma)
    # the trapezium rule, exact up to dt^3 times a second derivative that the rates bound
    rate = max(abs(model.alpha), abs(model.k2) ** 0.5, len(forcing.cos) * forcing.omega)
    slack = dt * (rate * dt) ** 2 * (np.abs(a).max() + rate * np.abs(v).max() + 1e-12) + 1e-13
    wrong_u = np.abs(np.diff(u) - 0.5 * dt * (v[1:] + v[:-1])) > slack
    wrong_v = np.abs(np.diff(v) - 0.5 * dt * (a[1:] + a[:-1])) > slack * max(1.0, rate)
    bad = flying & (wrong_u | wrong_v)
    assert not bad.any(), f"{said}: the equation of motion fails near t = {t[:-1][bad][:1]}"


def _check_returns(model: Oscillator, Q: Map, flown: Any, said: str) -> None:
    times, after = flown.impact_time.values, flown.v_plus.values
    for i in range(min(4, len(times) - 1)):
        (tau, w), _letter = Q((times[i] % model.period, after[i]))
        late = abs((tau - times[i + 1] + 0.5 * model.period) % model.period - 0.5 * model.period)
        slow = 1e-11 / max(abs(flown.v_minus.values[i + 1]), 1e-3) ** 2
        assert late <= slow, f"{said}: impact {i + 1} at {times[i + 1]}, the impact map is {late:.1e} off"
        assert abs(w - after[i + 1]) <= slow, (
            f"{said}: impact {i + 1} leaves with {after[i + 1]}, the impact map says {w}"
        )
