"""A promise that does not hold is found, with a counterexample; one that holds is not."""

import dataclasses
import threading

import pytest
from flint import ctx

import grazing as gz
from grazing.systems.precise import BITS, digits
from tests.systems.balls import beam, billiard, bouncing, parabola, table, table_bound
from tests.systems.models import oscillator, oscillator_bound, oscillator_flight, wall_below


@pytest.mark.parametrize(
    "system",
    [bouncing(A=0.05, height=0.6), billiard(), beam(), oscillator()[0], oscillator(alpha=3.0, k=1.0, walls=2)[0]],
    ids=["table", "billiard", "beam", "one wall", "two walls"],
)
def test_what_is_right_passes(system):
    gz.testing.check_system(system, states=3)


def ball(flight=parabola, gap=table, bound=table_bound, law=None, **options):
    one = bouncing(A=0.05)
    options = {"period": one.period} | options
    surface = gz.Surface("A", gap, bound, law)
    return gz.System(("x",), ("v",), one.params, flight, [surface], one.box, **options)


def small_bound(t, w, state, p):
    return p.g + 0.5 * p.A * p.omega * p.omega


def heavy(t, t0, state, p):
    x, v = state
    s = t - t0
    return x + 1.1 * (v - 0.5 * p.g * s) * s, v - p.g * s


def late(t, t0, state, p):
    x, v = state
    s = t - t0
    return x + v * s - 0.5 * s * s * t, v - s * t - 0.0 * t0


def no_motion(t, state, p):
    h, _dh = table(t, state, p)
    return h, state[1]


def sticky(t, state, p):
    return state[0] + 1e-3, -state[1] + 0.0 * t


def coarse(t, t0, state, p):
    return 1e-30, 1e-30


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (ball(bound=small_bound), r"the bound of surface A is 1\.98.* but h'' = -?\d"),
        (ball(flight=heavy), r"along the flight from x = .* x changes at .* where v = "),
        (ball(flight=late), r"the flight from .* but flown to t = .* and on from there"),
        (ball(gap=no_motion), r"the gap of surface A changes at .* but says dh = "),
        (ball(law=sticky), r"the law of surface A moves the gap from .* to "),
        (ball(rounding=coarse), r"is computed with an error of .* more than the 1.0e-30 that is said"),
        (ball(period=0.7), r"the gap of surface A is not the same a period, 0.7, later"),
    ],
)
def test_what_is_wrong_is_shown_by_an_example(system, said):
    with pytest.raises(AssertionError, match=said):
        gz.testing.check_system(system, states=4)


def drifting(t, t0, state, p):
    u, v = oscillator_flight(t, t0, state, p)
    return u + 1e-6 * v * (t - t0), v


def no_bound(t, w, state, p):
    return 0.0 * oscillator_bound(t, w, state, p)


@pytest.mark.parametrize(("L", "T"), [(1e-6, 1e-3), (2.0**-40, 1.0), (1.0, 2.0**40), (2.0**-60, 2.0**-40)])
def test_what_is_right_and_what_is_wrong_is_so_in_any_unit(L, T):
    # errors were compared with 1 of whatever unit, and rates were differences over 2^-50 of it
    right = oscillator(walls=2, L=L, T=T)[0]
    gz.testing.check_system(right, states=2)
    with pytest.raises(AssertionError, match=r"is at u = .* but flown to t = .* and on from there"):
        gz.testing.check_system(dataclasses.replace(right, flight=drifting), states=1)
    with pytest.raises(AssertionError, match=r"the bound of surface A is 0\.0 .* but h'' = "):
        bad = gz.Surface("A", wall_below, no_bound)
        gz.testing.check_system(dataclasses.replace(right, surfaces=[bad, right.surfaces[1]]), states=1)


def test_two_threads_have_their_digits_and_leave_none_behind():
    # precision belongs to the process: the first to end took it from the other, which left its own for ever
    before, inside, seen = ctx.prec, threading.Event(), []

    def first():
        with digits():
            inside.set()
            ready.wait(0.2)

    def second():
        inside.wait()
        with digits():
            thread.join(0.2)
            seen.append(ctx.prec)

    ready, thread = threading.Event(), threading.Thread(target=first)
    other = threading.Thread(target=second)
    for one in (thread, other):
        one.start()
    for one in (thread, other):
        one.join()
    assert seen == [BITS] and ctx.prec == before


def test_only_systems_are_checked():
    with pytest.raises(gz.InputError, match=r"system is .*; give a gz.System"):
        gz.testing.check_system(gz.pinball())
