"""Bounds of gaps along a flight, and their roots."""

import threading
from itertools import product

import numpy as np
import pytest
from flint import ctx
from mpmath import mp

from grazing.billiard.gaps import crossing, face_crossing, face_root, highest, landing, lowest, safe_step
from grazing.billiard.roots import precision
from grazing.outcome import AMBIGUOUS, GRAZE


def test_bounds_are_bounds():
    random = np.random.default_rng(0)
    for _ in range(300):
        c3, a4, w = random.normal(), abs(random.normal()) * random.integers(0, 2), random.exponential()
        s = np.linspace(0.0, w, 400)
        values = (c3 + a4 * s) * s
        assert lowest(c3, a4, w) <= values.min() + 1e-15 and highest(c3, a4, w) >= values.max() - 1e-15
        assert (
            lowest(c3, a4, w) >= values.min() - 1e-3 * (abs(c3) + a4 + 1) * w
            and highest(c3, a4, w) <= values.max() + 1e-12
        )
        h, dh, k = random.exponential(), random.normal(), random.normal()
        step = safe_step(h, dh, k)
        below = np.roots([k, dh, h])
        roots = sorted(r.real for r in below if abs(r.imag) < 1e-12 and r.real > 0.0)
        assert step == pytest.approx(roots[0]) if roots else step == float("inf")
    assert landing(1.0, -1.0, 0.0, 0.0, 0.0, 2.0) == 1.0


def test_a_crossing_is_the_first_root_of_the_quartic_from_either_side():
    """Against roots of numpy, circles met from outside and from inside, with and without gravity."""
    random, met = np.random.default_rng(1), 0
    for _ in range(300):
        dx, dy, vx, vy = random.normal(size=4)
        g, size = random.choice([0.0, 1.0]), random.uniform(0.3, 1.5)
        h = [
            g * g / 4.0,
            -vy * g,
            vx * vx + vy * vy - g * dy,
            2.0 * (dx * vx + dy * vy),
            dx * dx + dy * dy - size * size,
        ]
        sign = 1.0 if h[-1] > 0.0 else -1.0
        roots = np.roots(np.trim_zeros(h, "f"))
        down = sorted(z.real for z in roots if abs(z.imag) < 1e-9 and z.real > 0.0
                      and sign * np.polyval(np.polyder(h), z.real) < 0.0)  # fmt: skip
        t, late, flags = crossing(dx, dy, vx, vy, g, size, sign, 0.0, False, 50.0)
        expected = down[0] if down and down[0] < 50.0 else float("inf")
        assert flags == 0 and t == pytest.approx(expected, rel=1e-9) and 0.0 <= late < 1e-11
        met += t < 50.0
    assert met > 100


def test_a_face_is_crossed_where_the_quadratic_falls_through_zero():
    random = np.random.default_rng(2)
    for _ in range(300):
        h, dh, k = random.normal(size=3)
        down = [
            z.real for z in np.roots([k, dh, h]) if abs(z.imag) < 1e-12 and z.real > 0.0 and 2 * k * z.real + dh < 0
        ]
        t, late, flags = face_crossing(h, dh, k, 1e-16, 1e-16, False)
        assert flags == 0 and t == pytest.approx(down[0] if down else float("inf"), rel=1e-12)
        assert t == float("inf") or 0.0 < late < 1e-10
    assert face_crossing(1.0, -2.0, 1.0, 1e-16, 1e-16, False)[2] == GRAZE | AMBIGUOUS
    assert face_crossing(0.0, 2.0, -1.0, 1e-16, 1e-16, True)[0] == 2.0


def falls_to_zero(h, dh, k):
    """Return where h + dh t + k t^2 comes down to 0, to sixty digits; None for nowhere."""
    with mp.workdps(60):
        h, dh, k = mp.mpf(h), mp.mpf(dh), mp.mpf(k)
        D = dh * dh - 4 * k * h
        if k == 0:
            return -h / dh if dh < 0 else None
        return -(dh + mp.sqrt(D)) / (2 * k) if D > 0 else None


def test_the_root_of_a_face_is_the_closed_form_and_as_late_as_its_errors_make_it():
    """Against sixty digits: flat and bent flights, down and from behind, at all scales, and with the gap's errors."""
    random, sure_ones, far = np.random.default_rng(21), 0, 0
    for _ in range(3000):
        size, speed = 10.0 ** random.uniform(-6, 6, 2)
        h = size * float(random.choice([0.0, 1e-9, 1.0])) * abs(random.normal()) * random.choice([1.0, 1.0, 1.0, -1.0])
        dh = speed * random.normal()
        k = float(random.choice([0.0, 1e-12, 1.0, 1e6])) * random.normal() * speed * speed / size
        e, d = 1e-15 * (abs(h) + size), 1e-15 * speed
        sure, t, late = face_root(h, dh, k, e, d, False)
        exact = falls_to_zero(h, dh, k)
        if not sure:
            D, wide = dh * dh - 4.0 * k * h, 8.0 * (abs(dh) * d + abs(k) * e) + 1e-13 * (dh * dh + 4.0 * abs(k * h))
            assert exact is None or exact < 0 or D < wide or h < -e
            continue
        sure_ones += 1
        assert exact is not None and abs(max(exact, 0) - t) <= 4e-15 * t + 2.0 * e / (
            exact_rate := abs(dh + 2.0 * k * t)
        )
        assert late <= 3.0 * (e + d * t) / exact_rate + 1e-15 * t
        for up, faster in product((-1.0, 1.0), repeat=2):
            with mp.workdps(60):
                other = falls_to_zero(mp.mpf(h) + up * mp.mpf(e), mp.mpf(dh) + faster * mp.mpf(d), k)
                assert other is not None and abs(max(other, 0) - t) <= late
            far += 1
    assert 1000 < sure_ones < 2900 and far == 4 * sure_ones


def test_a_face_just_left_is_met_again_where_the_fall_back_ends():
    """At -dh/k, as late as the error of the gap there makes it; not at all for one that does not fall back."""
    random = np.random.default_rng(22)
    for _ in range(1000):
        dh, k = 10.0 ** random.uniform(-6, 6), random.normal() * 10.0 ** random.uniform(-6, 6)
        e = 1e-15 * dh * dh / abs(k)
        sure, t, late = face_root(random.normal(), dh, k, e, 1e-16 * dh, True)
        assert sure == (k < 0.0)
        if sure:
            with mp.workdps(60):
                assert abs(-mp.mpf(dh) / mp.mpf(k) - t) <= 2.3e-16 * t
                assert abs(falls_to_zero(0.5 * e, dh, k) - t) <= late + 2.3e-16 * t
        assert not face_root(0.0, -dh, abs(k), e, 0.0, True)[0]
        assert not face_root(0.0, dh, -abs(k), dh * dh / abs(k), 0.0, True)[0]  # it rises by less than can be told


def test_the_precision_of_the_process_is_set_by_one_thread_at_a_time():
    """Each left the other's behind."""
    before, inside = ctx.prec, threading.Event()

    def work():
        with precision(301):
            inside.set()

    thread = threading.Thread(target=work)
    with precision(300):
        thread.start()
        assert not inside.wait(0.05) and ctx.prec == 300
    thread.join()
    assert inside.is_set() and ctx.prec == before
