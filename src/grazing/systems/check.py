"""What a system of one's own promises, held against its functions in many digits, a dense search and built grazes."""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from grazing.outcome import AMBIGUOUS, InputError, UserCodeError, told
from grazing.parameter import parameters
from grazing.systems.contract import Surface, System
from grazing.systems.precise import STEP, balls, digits, in_balls, middle
from grazing.systems.trajectory import AFTER, BEFORE, BEGIN, END, FLAGS, HEAD, HIT, flights_of

Floats = NDArray[np.float64]
State = tuple[float, ...]
#: How far two exact things may differ, as a share of the sizes involved: constants may be rounded.
SAME = 1e-12
#: Places at which an interval is looked at, flights of a start that are searched, and depths of built grazes.
PLACES, FLIGHTS, DEPTHS = 64, 12, (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


class Checked:
    """A system with its functions in many digits."""

    def __init__(self, system: System) -> None:
        self.system, self.p = system, parameters(system.params)
        self.exact, self.n = balls(self.p), len(system.positions)
        self.flight = in_balls(system.flight)
        self.gap = {one.name: in_balls(one.gap) for one in system.surfaces}
        self.widths, self.span = [high - low for low, high in system.box], system.span
        self.step = arb(STEP * self.span)

    def rate(self, along: Any, t: Any) -> Any:
        """Return the rate at t of something of the time, by differences of the fourth order."""
        near = [along(arb(t) + k * self.step) for k in (1, -1, 2, -2)]
        return (8 * (near[0] - near[1]) - (near[2] - near[3])) / (12 * self.step)

    def gap_along(self, one: Surface, t: Any, t0: float, state: State) -> tuple[Any, Any]:
        """Return gap and rate at t along the exact flight, as balls."""
        now = self.flight(t, arb(t0), balls(state), self.exact)
        h, dh = self.gap[one.name](t, now, self.exact)
        return arb(h), arb(dh)

    def bend(self, one: Surface, t: float, t0: float, state: State) -> float:
        """Return h'' at t along the exact flight."""
        return middle(self.rate(lambda at: self.gap_along(one, at, t0, state)[1], t))

    def gap_in_doubles(self, one: Surface, t: float, t0: float, state: State) -> tuple[float, float, float, float]:
        """Return gap and rate as computed, and what is said of their errors."""
        now = self.system.flight(t, t0, state, self.p)
        h, dh = one.gap(t, now, self.p)
        e, d = self.system.parts[2](t, t0, state, now, h, dh, self.p)
        return h, dh, e, d

    def said(self, t0: float, state: State) -> str:
        """Return a start in words."""
        names = zip(self.system.coordinates, state, strict=True)
        return f"from {', '.join(f'{name} = {x!r}' for name, x in names)} at t = {t0!r}"


def check(system: System, states: int, seed: int) -> None:
    """Raise AssertionError for a promise that does not hold; :func:`grazing.testing.check_system` calls this."""
    random, box = np.random.default_rng(seed), np.array(system.box)
    widths, span, one = box[:, 1] - box[:, 0], system.span, Checked(system)
    with digits():
        for _ in range(states):
            state: State = tuple(random.uniform(box[:, 0], box[:, 1]).tolist())
            t0 = float(random.uniform(0.0, span))
            try:
                _check_flight(one, state, t0, float(random.uniform(0.1, 1.0)) * span)
                for surface in system.surfaces:
                    _check_gap(one, surface, state, t0, float(random.uniform(0.0, 1.0)) * span)
                    for _again in range(4):
                        t = t0 + float(random.uniform(0.0, 0.5)) * span
                        _check_bound(one, surface, state, t0, t, float(10.0 ** random.uniform(-3.0, 0.0)) * span)
            except (TypeError, ValueError, AttributeError, ZeroDivisionError) as error:
                raise UserCodeError(f"a function of {system.name} raised {told(error)} in ball arithmetic") from error
            inside = any(h < 0.0 for h, _dh in system.gaps(t0, state, system.params).values())
            if not inside:
                _check_impacts(one, state, t0, span)
                for depth in DEPTHS:
                    _check_grazes(one, state, t0, span, depth, widths)


def _apart(a: Any, b: Any, size: float) -> bool:
    return not abs(middle(arb(a) - b)) <= SAME * size


def _check_flight(one: Checked, state: State, t0: float, s: float) -> None:
    """Hold the flight to what flights are: one through its own start, made of halves, its velocities its rates."""
    fly, p, start, names = one.flight, one.exact, balls(state), one.system.coordinates
    t, half, said = arb(t0) + s, arb(t0) + 0.375 * s, one.said(t0, state)
    at_once, there = fly(arb(t0), arb(t0), start, p), fly(t, arb(t0), start, p)
    sizes = [max(abs(middle(x)), abs(middle(y)), w) for x, y, w in zip(there, start, one.widths, strict=True)]
    assert np.isfinite(sizes).all(), f"the flight {said} is not finite {s:g} later: {[middle(x) for x in there]}"
    by_halves = fly(t, half, fly(half, arb(t0), start, p), p)
    for i, name in enumerate(names):
        assert not _apart(at_once[i], start[i], sizes[i]), (
            f"the flight {said} to the same time has {name} = {middle(at_once[i])!r}; it must stay where it is"
        )
        assert not _apart(by_halves[i], there[i], sizes[i]), (
            f"the flight {said} is at {name} = {middle(there[i])!r} at t = {middle(t)!r}, but flown to t = "
            f"{middle(half)!r} and on from there it is at {middle(by_halves[i])!r}"
        )
    for i in range(one.n):
        rate = one.rate(lambda at, i=i: fly(at, arb(t0), start, p)[i], t)
        assert not _apart(rate, there[one.n + i], sizes[one.n + i]), (
            f"along the flight {said} {names[i]} changes at {middle(rate)!r} at t = {middle(t)!r}, where "
            f"{names[one.n + i]} = {middle(there[one.n + i])!r}"
        )
    if one.system.period is not None:
        T = one.system.period_at(one.system.params)
        later = fly(t + T, arb(t0) + T, start, p)
        for i, name in enumerate(names):
            assert not _apart(later[i], there[i], sizes[i]), (
                f"the flight {said} is not the same a period, {T!r}, later: {name} = {middle(there[i])!r} and "
                f"{middle(later[i])!r}"
            )


def _check_gap(one: Checked, surface: Surface, state: State, t0: float, s: float) -> None:
    """Hold a gap to its rate, to what Newton's law asks of it, and to what is said of its rounding."""
    t, said = t0 + s, f"along the flight {one.said(t0, state)} the gap of surface {surface.name}"
    h, dh = one.gap_along(surface, arb(t), t0, state)
    rate = one.rate(lambda at: one.gap_along(surface, at, t0, state)[0], t)
    size = max(abs(middle(h)), abs(middle(dh)) * one.span)
    assert not _apart(rate, dh, size / one.span), (
        f"{said} changes at {middle(rate)!r} at t = {t!r}, but says dh = {middle(dh)!r}"
    )
    computed, computed_rate, e, d = one.gap_in_doubles(surface, t, t0, state)
    for what, got, true, allowed in (("h", computed, h, e), ("dh", computed_rate, dh, d)):
        error = abs(middle(true - got))
        assert error <= allowed, (
            f"{said} is computed with an error of {error:.1e} in {what} at t = {t!r}, more than the {allowed:.1e} that "
            "is said; give gz.System(..., rounding=)"
        )
    if one.system.period is not None:
        now, T = one.flight(arb(t), arb(t0), balls(state), one.exact), one.system.period_at(one.system.params)
        again = arb(one.gap[surface.name](arb(t) + T, now, one.exact)[0])
        assert not _apart(again, h, size), (
            f"the gap of surface {surface.name} is not the same a period, {T!r}, later: {middle(h)!r} at t = {t!r}, "
            f"then {middle(again)!r}, for the state {tuple(middle(x) for x in now)}"
        )
    if surface.law is None:
        rest, once, twice = (
            one.gap[surface.name](arb(t), (*balls(state[: one.n]), *(k * arb(v) for v in state[one.n :])), one.exact)[1]
            for k in (0, 1, 2)
        )
        assert not _apart(twice - once, once - rest, max(size / one.span, abs(middle(once)))), (
            f"the rate of the gap of surface {surface.name} is not affine in the velocities at {state}, t = {t!r}; "
            "Newton's law cannot be read from it: give a law"
        )


def _check_bound(one: Checked, surface: Surface, state: State, t0: float, t: float, w: float) -> None:
    """Hold a bound to h'' at many places of an interval."""
    now = tuple(float(x) for x in one.system.flight(t, t0, state, one.p))
    M = surface.bound(t, w, now, one.p)
    assert M >= 0.0, f"the bound of surface {surface.name} is {M!r} at t = {t!r}, w = {w!r}, state {now}"
    for s in np.linspace(0.0, w, PLACES).tolist():
        bend, (h, dh) = one.bend(surface, t + s, t, now), one.gap_along(surface, arb(t + s), t, now)
        size = (abs(middle(h)) / one.span + abs(middle(dh))) / one.span
        assert abs(bend) <= M * (1.0 + SAME) + SAME * size, (
            f"the bound of surface {surface.name} is {M!r} on [{t!r}, {t + w!r}] along the flight from {now}, but "
            f"h'' = {bend!r} at t = {t + s!r}"
        )


def _check_impacts(one: Checked, state: State, t0: float, span: float) -> None:
    """Hold the march to a dense search, and laws to what they must do."""
    system, said, n2 = one.system, one.said(t0, state), 2 * one.n
    try:
        flights = flights_of(system, state, t0, t0 + span)
    except UserCodeError as error:
        raise AssertionError(str(error)) from None
    for flight in flights[:FLIGHTS]:
        begin, end, hit = float(flight[BEGIN]), float(flight[END]), int(flight[HIT])
        first = tuple(flight[HEAD : HEAD + n2].tolist())
        if int(flight[FLAGS]) & AMBIGUOUS or not np.isfinite(flight[END]):
            continue
        for t in np.linspace(begin, end, PLACES)[1:-1].tolist():
            for surface in system.surfaces:
                h, _dh, e, _d = one.gap_in_doubles(surface, t, begin, first)
                assert h >= -8.0 * e, f"{said}: surface {surface.name} is missed, its gap is {h!r} at t = {t!r}"
        if np.isnan(flight[BEFORE]):
            continue
        surface = system.surfaces[hit]
        h, dh, e, d = one.gap_in_doubles(surface, end, begin, first)
        assert abs(h) <= 8.0 * e + abs(dh) * 4e-16 * abs(end), (
            f"{said}: an impact with surface {surface.name} at t = {end!r}, where its gap is {h!r}"
        )
        assert flight[AFTER] >= -d, f"{said}: surface {surface.name} is left at t = {end!r} at {flight[AFTER]!r}"
        left = tuple(flight[HEAD + 2 * n2 :].tolist())
        after = surface.gap(end, left, one.p)[0]
        assert abs(after - h) <= 8.0 * e + SAME * abs(h), (
            f"the law of surface {surface.name} moves the gap from {h!r} to {after!r} at t = {end!r}, {said}"
        )


def _check_grazes(one: Checked, state: State, t0: float, span: float, depth: float, widths: Floats) -> None:
    """Build flights that dip a little below a surface, or stay a little above it, and hold the march to them."""
    for surface in one.system.surfaces:
        for target in (-depth, depth):
            built = _grazing(one, surface, state, t0, span, target, widths)
            if built is None:
                continue
            start, t = built
            truth = middle(one.gap_along(surface, arb(t), t0, start)[0])
            later = min(t + 1e-3 * span, t0 + span)
            try:
                first = flights_of(one.system, start, t0, later)[0]
            except (UserCodeError, InputError):
                continue
            hit, end = int(first[HIT]), float(first[END])
            if hit >= 0 and one.system.surfaces[hit] is not surface:
                continue
            reach = 1e-2 * span  # a dip is as wide as its root is deep
            said = f"{one.said(t0, start)} the gap of surface {surface.name} has the minimum {truth:.3e} at t = {t!r}"
            if truth < 0.0:
                assert hit >= 0 or int(first[FLAGS]) & AMBIGUOUS, f"{said}; no impact was found"
            elif not int(first[FLAGS]) & AMBIGUOUS:
                assert hit < 0 or abs(end - t) > reach, f"{said}; an impact was found at t = {end!r}"


def _grazing(
    one: Checked, surface: Surface, state: State, t0: float, span: float, target: float, widths: Floats
) -> tuple[State, float] | None:
    """Return a start near a state whose gap has its first minimum near 0 at ``target``, and when; None if none is."""

    def low(start: State, near: float) -> tuple[float, float] | None:
        t, w = near, 1e-2 * span
        for _ in range(60):
            _h, dh, _e, _d = one.gap_in_doubles(surface, t, t0, start)
            _h, later, _e, _d = one.gap_in_doubles(surface, t + 1e-6 * span, t0, start)
            bend = (later - dh) / (1e-6 * span)
            if not bend > 0.0 or not abs(dh / bend) < w:
                return None
            t -= dh / bend
            if abs(dh / bend) < 1e-12 * span:
                return t, one.gap_in_doubles(surface, t, t0, start)[0]
        return t, one.gap_in_doubles(surface, t, t0, start)[0]

    places = np.linspace(t0, t0 + span, 8 * PLACES).tolist()
    rates = [one.gap_in_doubles(surface, t, t0, state)[1] for t in places]
    turns = [t for t, a, b in zip(places, rates, rates[1:], strict=False) if a < 0.0 <= b]
    found = low(state, turns[0]) if turns else None
    if found is None:
        return None
    for i in range(2 * one.n):
        start, (t, h) = state, found
        step = 1e-4 * float(widths[i])
        for _ in range(30):
            if abs(h - target) <= 0.1 * abs(target):
                outside = all(gap >= 0.0 for gap, _dh in one.system.gaps(t0, start, one.system.params).values())
                return (start, t) if outside else None
            moved = (*start[:i], start[i] + step, *start[i + 1 :])
            there = low(moved, t)
            if there is None or there[1] == h:
                break
            change = (target - h) / (there[1] - h) * step
            if not abs(change) < 0.25 * float(widths[i]):
                change = 0.25 * float(widths[i]) * (1.0 if change > 0.0 else -1.0)
            start = (*start[:i], start[i] + change, *start[i + 1 :])
            again = low(start, t)
            if again is None:
                break
            t, h = again
    return None
