"""Laws that every map must keep, held against its own step in plain Python, differences and other company."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.hits import Hits
from grazing.maps.map import Map, swift
from grazing.outcome import AMBIGUOUS, FATAL, GRAZE, STUCK, UserCodeError, told
from grazing.parameter import parameters

#: Outcomes at which a map need not be smooth.
ROUGH = FATAL | AMBIGUOUS | GRAZE | STUCK


def check(P: Map, states: int, steps: int, seed: int) -> None:
    """Raise AssertionError with the first law that a map breaks, and the state."""
    starts = random_starts(P, states, seed)
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


def random_starts(P: Map, n: int, seed: int) -> NDArray[np.float64]:
    """Return n states of the box of a map."""
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
        orbit = swift(P).orbit(start, steps)  # what ball arithmetic decides, the plain step leaves ambiguous
        state: Any = tuple(start.tolist())
        for i in range(steps):
            try:
                state, letter, outcome = P._full_step(state, c)
            except Exception as error:
                raise UserCodeError(f"{P.name}: in plain Python the step from {state} raised {told(error)}") from error
            said = f"{P.name}: compiled and plain step differ at step {i + 1} from {start.tolist()}"
            here = np.array(state, dtype=np.float64)
            alike, why = _equal(here, orbit.points[i + 1]), ""
            with np.errstate(all="ignore"):
                if not alike and np.allclose(here, orbit.points[i + 1], rtol=1e-12, atol=0.0, equal_nan=True):
                    why = "; by rounding alone: x**3 is compiled as x*x*x, so write that in code of your own"
            assert alike, said + why
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
    rough = any(one.outcomes[0] & ROUGH or one.letters[0] != here.letters[0] for one in [here, *near])
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
            if one.outcomes[0, 0, i] & ROUGH:
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
    copies = max(2, -(-700 // n))
    many = np.stack([np.tile(states, (1, copies)), np.tile(states[:, ::-1], (1, copies))])
    for threads in (1, 2):
        crowd = P.run_columns(np.repeat(row, 2, axis=0), many.copy(), 1, steps, threads=threads)
        said = f"{P.name}: with {threads} thread(s) and other orbits beside it an orbit has other bits"
        for q, order in enumerate((slice(None), slice(None, None, -1))):
            for first in (0, n * (copies - 1)):
                part = slice(first, first + n)
                assert _equal(crowd.points[q, :, :, part], alone.points[0][:, :, order]), said
                assert _equal(crowd.letters[q, :, part], alone.letters[0][:, order]), said
