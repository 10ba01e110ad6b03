"""Maps whose attractors, basins or exponents are known, in one to three dimensions."""

import math

import numpy as np

import grazing as gz


def logistic_step(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


def logistic_tangent(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),), 0, 0, (p.a * (1.0 - 2.0 * x),)


LOGISTIC = gz.Map(logistic_step, params={"a": 3.2}, coordinates=("x",), box=((0.05, 0.95),), name="logistic map")
#: The same with a derivative of its own.
SMOOTH = gz.Map(
    logistic_step, params={"a": 3.2}, coordinates=("x",), box=((0.05, 0.95),), name="logistic map",
    tangent=logistic_tangent,
)  # fmt: skip


def henon_step(state, p):
    x, y = state
    return (1.0 - p.a * x * x + y, p.b * x), (0 if x < 0.0 else 1), 0


def henon_tangent(state, p):
    x, _y = state
    new, letter, outcome = henon_step(state, p)
    return new, letter, outcome, (-2.0 * p.a * x, 1.0, p.b, 0.0)


HENON = gz.Map(
    henon_step, params={"a": 1.4, "b": 0.3}, coordinates=("x", "y"), box=((-0.1, 0.1),) * 2, letters="LR",
    tangent=henon_tangent, escape=1e3, name="Henon map",
)  # fmt: skip


def spiral_step(state, p):
    x, y = state
    c, s = p.r * math.cos(p.turn), p.r * math.sin(p.turn)
    return c * x - s * y + p.shift, s * x + c * y


SPIRAL = gz.Map(
    spiral_step, params={"r": 0.9, "turn": 1.0, "shift": 0.3}, coordinates=("x", "y"), box=((-1.0, 1.0),) * 2,
    name="spiral",
)  # fmt: skip


def follower_step(state, p):
    """A logistic map, and two coordinates that follow it."""
    x, y, z = state
    return (p.a * x * (1.0 - x), p.b * y + x, p.c * z + y), (1 if x > 0.5 else 0), 0


def follower_tangent(state, p):
    x, _y, _z = state
    new, letter, outcome = follower_step(state, p)
    return new, letter, outcome, (p.a * (1.0 - 2.0 * x), 0.0, 0.0, 1.0, p.b, 0.0, 0.0, 1.0, p.c)


FOLLOWER = gz.Map(
    follower_step, params={"a": 3.2, "b": 0.5, "c": -0.3}, coordinates=("x", "y", "z"), letters="LR",
    box=((0.05, 0.95), (-1.0, 1.0), (-1.0, 1.0)), tangent=follower_tangent, name="follower",
)  # fmt: skip


def double_well_step(state, p):
    """An odd map: the fixed points sqrt(a - 1) and -sqrt(a - 1) attract, 0 is between them; for 2 < a < ... cycles."""
    (x,) = state
    return (p.a * x - x * x * x,)


DOUBLE_WELL = gz.Map(double_well_step, params={"a": 1.5}, coordinates=("x",), box=((-1.2, 1.2),), name="double well")


def plane_wells_step(state, p):
    """Two wells in x; y follows and is forgotten."""
    x, y = state
    return p.a * x - x * x * x, 0.5 * y + p.pull * x


PLANE_WELLS = gz.Map(
    plane_wells_step, params={"a": 1.5, "pull": 0.2}, coordinates=("x", "y"), box=((-1.2, 1.2),) * 2,
    name="plane wells",
)  # fmt: skip


def tent_escape_step(state, p):
    """x -> 3 x on the left and 3 (1 - x) on the right; what leaves [0, 1] goes to one of two far fixed points.

    The points that never leave are the middle-thirds Cantor set, of dimension ln 2/ln 3.
    """
    (x,) = state
    if x < 0.0:
        return (0.5 * (x - 2.0),), 0, 0
    if x > 1.0:
        return (0.5 * (x + 4.0),), 1, 0
    return (3.0 * x if x < 0.5 else 3.0 - 3.0 * x,), 2, 0


def linear_map(matrix):
    """A linear map of any dimension, its matrix in the parameters."""
    A = np.asarray(matrix, np.float64)
    d = len(A)
    names = [f"m{i}{j}" for i in range(d) for j in range(d)]

    if d == 1:

        def tangent(state, p):
            return (p.m00 * state[0],), 0, 0, (p.m00,)

    elif d == 2:

        def tangent(state, p):
            x, y = state
            return (p.m00 * x + p.m01 * y, p.m10 * x + p.m11 * y), 0, 0, (p.m00, p.m01, p.m10, p.m11)

    else:

        def tangent(state, p):
            x, y, z = state
            new = (
                p.m00 * x + p.m01 * y + p.m02 * z,
                p.m10 * x + p.m11 * y + p.m12 * z,
                p.m20 * x + p.m21 * y + p.m22 * z,
            )
            return new, 0, 0, (p.m00, p.m01, p.m02, p.m10, p.m11, p.m12, p.m20, p.m21, p.m22)

    def step(state, p):
        new, letter, outcome, _J = tangent(state, p)
        return new, letter, outcome

    return gz.Map(
        step, params=dict(zip(names, A.ravel().tolist(), strict=True)), coordinates=("x", "y", "z")[:d],
        box=((-1.0, 1.0),) * d, tangent=tangent, name="linear map",
    )  # fmt: skip


def states_in(P, n, seed=0):
    """Random states in the box of a map, shape (dim, n)."""
    box = np.array(P.box)
    return np.random.default_rng(seed).uniform(box[:, 0], box[:, 1], (n, P.dimension)).T.copy()
