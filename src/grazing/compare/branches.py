"""The orbit with one impact in N periods on a rung below the flow, followed in the speed s of its impact.

On every rung the state before the impact is w and the one after it z, and N periods close the orbit: w = S + E (z - S)
with S the fixed point of the period without impact and E its N-th power. As functions of s (and of the time delta to
the wall) w and z are smooth, also at the graze s = 0, where the map itself has a square root. With J = E Dz Dw^-1:
det(Dw + E Dz), det(Dw - E Dz) and det Dw - det E det Dz are det Dw times 1 + tr + det, 1 - tr + det and 1 - det of J.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grazing.maps.normal_form import NormalForm, constants
from grazing.oscillator.constants import forcing, steady_response
from grazing.oscillator.flight import modes
from grazing.oscillator.model import Oscillator
from grazing.outcome import GrazingError

Floats = NDArray[np.float64]
#: Steps of Newton's method; sizes of a step, relative, at which it has arrived, and below which it may stall: rounding.
STEPS, ARRIVED, STALLED = 40, 1e-13, 1e-5


class Point(NamedTuple):
    """An orbit of a branch: impact speed s, time to the wall, parameter, and its test functions.

    ``tests`` (3,) are those of pd, lp and ns, positive inside a window. ``left`` (N - 1,) are positive where the
    points without impact, in the order of time, lie left of the border.
    """

    s: float
    delta: float
    value: float
    tests: Floats
    left: Floats


class Rung(Protocol):
    """A rung: the orbit with one impact in N periods of which the impact has speed s, or None where there is none."""

    N: int

    def at(self, s: float, near: Point | None) -> Point | None:
        """Return the orbit at s, found from one nearby."""
        ...


def stability(w: Floats, z: Floats, E: Floats) -> Floats:
    """Return the test functions of pd, lp and ns from the derivatives of w and z, all times |det w|."""
    size, image = det(w), E @ z
    tests = np.array([det(w + image), det(w - image), size - det(image)])
    return tests if size >= 0.0 else -tests


def det(a: Floats) -> float:
    """Return the determinant of a 2 x 2 matrix."""
    return float(a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0])


class Linearised:
    """The rung of the linearised map (:mod:`grazing.maps.linearised`), in closed form.

    The first component of the orbit's equation, x = s^2 = a mu - b (root s + l), gives mu(s).
    """

    def __init__(self, form: NormalForm, N: int) -> None:
        self.form, self.N = form, N
        self.root = 1.0 if form.b > 0.0 else -1.0
        M = np.array([[form.lam, 1.0], [-form.det, 0.0]])
        self.powers = [np.eye(2)]
        for _ in range(N):
            self.powers.append(M @ self.powers[-1])
        inverse = np.linalg.inv(np.eye(2) - self.powers[N])
        push = np.array([1.0, 0.0])
        self.drift = inverse @ sum(self.powers[:N], np.zeros((2, 2))) @ push
        self.kick = inverse @ self.powers[N - 1] @ push

    def mu(self, s: float) -> float:
        """Return the mu at which the impact has speed s, in units of the root of the scale."""
        return float((s * s + self.kick[0] * (self.root * s + self.form.l)) / self.drift[0])

    def at(self, s: float, near: Point | None = None) -> Point:
        """Return the orbit at s; its value is mu."""
        mu, hit = self.mu(s), self.root * s + self.form.l
        w = self.drift * mu - self.kick * hit
        push = np.array([1.0, 0.0])
        state = self.powers[1] @ w + (mu - hit) * push
        left = []
        for _ in range(self.N - 1):
            left.append(-state[0])
            state = self.powers[1] @ state + mu * push
        before = np.array([[2.0 * s, 0.0], [0.0, 1.0]])
        after = self.powers[1] @ before - np.array([[self.root, 0.0], [0.0, 0.0]])
        return Point(s, 0.0, mu, stability(before, after, self.powers[self.N - 1]), np.array(left))


class Period(NamedTuple):
    """A model at one parameter value as its local map needs it: at the section, and after 0 to N periods."""

    alpha: float
    k2: float
    T: float
    F: float
    steady: Floats
    powers: list[Floats]


class Local:
    """The rung of the discontinuity map, of any order (:func:`grazing.discontinuity_map`), at the phase of the graze.

    The unknowns are s and delta: with the acceleration A at the section v = -s - A delta, y = s delta + A delta^2/2.
    A = F - alpha v - k^2 y is then linear in A. An impact before the section has delta < 0.
    """

    def __init__(self, model: Oscillator, form: NormalForm, N: int, order: str) -> None:
        self.model, self.form, self.N, self.order = model, form, N, order
        self._known: dict[float, Period] = {}
        self._least = 1e-12 * model.unit_of(form.name)  # of steps of the parameter, at the graze

    def period(self, value: float) -> Period:
        """Return the model at a value of the parameter."""
        if value not in self._known:
            c = constants(self.model.replace(**{self.form.name: value}))
            powers = [np.array(modes(k * c.T, c)).reshape(2, 2) for k in range(self.N + 1)]
            F, _rate = forcing(self.form.time, c)
            known = Period(c.alpha, c.k2, c.T, F, np.array(steady_response(self.form.time, c)), powers)
            if len(self._known) > 1000:
                self._known.clear()
            self._known[value] = known
        return self._known[value]

    def crossing(self, s: float, delta: float, p: Period) -> tuple[Floats, Floats, Floats, Floats]:
        """Return w, z and their derivatives in (s, delta): (2.2) to (2.5), continued to impacts before the section."""
        q = 1.0 - p.alpha * delta + 0.5 * p.k2 * delta * delta
        A = (p.F + p.alpha * s - p.k2 * s * delta) / q
        A_s = (p.alpha - p.k2 * delta) / q
        A_d = (A * (p.alpha - p.k2 * delta) - p.k2 * s) / q
        half = 0.5 * delta * delta
        w = np.array([s * delta + A * half, -s - A * delta])
        dw = np.array([[delta + A_s * half, s + A * delta + A_d * half], [-1.0 - A_s * delta, -A - A_d * delta]])
        r, V = self.form.r, self.form.V
        up = r * s + V
        if self.order == "lowest":
            return w, w + np.array([0.0, up + s]), dw, dw + np.array([[0.0, 0.0], [1.0 + r, 0.0]])
        drag = p.alpha if self.order == "corrected" else 0.0
        B, B_s = A - drag * (up + s), A_s - drag * (1.0 + r)
        z = np.array([B * half - delta * up, up - delta * B])
        dz = np.array([[B_s * half - delta * r, A_d * half + B * delta - up], [r - delta * B_s, -B - delta * A_d]])
        return w, z, dw, dz

    def at(self, s: float, near: Point | None) -> Point | None:
        """Return the orbit at s by Newton's method in (delta, value), from one nearby; None where it fails."""
        assert near is not None
        delta, value = near.delta, near.value
        if near.s > 0.0:
            delta *= s / near.s
        unit = abs(value - self.form.graze) + 1e-6 * abs(self.form.graze) + self._least
        before = np.inf
        try:
            for _ in range(STEPS):
                p = self.period(value)
                w, z, dw, dz = self.crossing(s, delta, p)
                E = p.powers[self.N]
                miss = w - p.steady - E @ (z - p.steady)
                h = 1e-6 * unit
                q = self.period(value + h)
                w_h, z_h, _dw, _dz = self.crossing(s, delta, q)
                slope = (w_h - q.steady - q.powers[self.N] @ (z_h - q.steady) - miss) / h
                step = np.linalg.solve(np.column_stack([(dw - E @ dz)[:, 1], slope]), miss)
                delta, value = delta - float(step[0]), value - float(step[1])
                size = float(max(abs(step[0]) / (abs(delta) + s), abs(step[1]) / unit))
                if size <= ARRIVED or before <= size <= STALLED:
                    near_by = abs(delta) < 0.5 * p.T  # else it is no impact about this section
                    return self._point(s, delta, value) if near_by else None
                before = size
        except (GrazingError, np.linalg.LinAlgError, ArithmeticError):
            return None
        return None

    def _point(self, s: float, delta: float, value: float) -> Point:
        p = self.period(value)
        _w, z, dw, dz = self.crossing(s, delta, p)
        left = []
        for k in range(1, self.N):
            y, v = p.steady + p.powers[k] @ (z - p.steady)
            A = p.F - p.alpha * v - p.k2 * y
            left.append(2.0 * A * y - v * v if v < 0.0 else y)  # letter R: x >= 0 and v < 0, or below the wall
        return Point(s, delta, value, stability(dw, dz, p.powers[self.N]), np.array(left))
