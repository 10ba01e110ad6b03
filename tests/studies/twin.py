"""A plain NumPy twin of the classification: slow, one orbit at a time, written from the rule and not from the code."""

from functools import reduce

import numpy as np

import grazing as gz
from grazing.orbits.word import word
from grazing.outcome import AMBIGUOUS, FATAL

UNDECIDED, APERIODIC, ENDED = 0, -1, -2
NO_TANGENT = object()


def classified(P, points, letters, outcomes, rtol=1e-9):
    """Period, word and trust of orbits: points (keep, dim, n), letters (keep, n), outcomes (n,)."""
    periods = [period_of(P, points[:, :, j], letters[:, j], int(outcomes[j]), rtol) for j in range(letters.shape[1])]
    words = [word(letters[-N:, j].tolist(), P.letters) if N > 0 else "" for j, N in enumerate(periods)]
    exact = 0 if P.tangent is not None and P.origin.exact else 1
    return periods, words, [2 if outcome & AMBIGUOUS else exact for outcome in outcomes.tolist()]


def period_of(P, x, s, outcome, rtol=1e-9):
    """The rule at the top of grazing.studies.classify, for one orbit: points x (keep, dim), letters s (keep,)."""
    keep = len(x)
    if outcome & FATAL or not np.isfinite(x).all():
        return ENDED
    if keep < 2:
        return UNDECIDED
    unit = np.ptp(P.box, axis=1)
    floor = 1e-13 * np.abs(x / unit).max() * unit
    extent = np.ptp(x, axis=0)
    tolerance = rtol * extent + floor
    extent = np.maximum(extent, 10.0 * floor + 1e-300)
    candidate = next((N for N in range(1, keep // 2 + 1) if recurs(x, s, N, tolerance)), 0)
    period = candidate or APERIODIC
    for N in range(1, keep // 3 + 1):
        divides = candidate > N and candidate % N == 0
        if not (divides or (candidate == 0 and 5 * N <= keep)):
            continue
        if (s[N:] != s[:-N]).any() or not settling(x / extent, N, tolerance / extent):
            continue
        cycle = cycle_beside(P, x[-1], s[-N:], tolerance)
        if cycle is NO_TANGENT:
            period = max(period, UNDECIDED)
        elif cycle is not None and approaches(*cycle, x, N, tolerance):
            return N
    return period


def recurs(x, s, N, tolerance):
    return bool((np.abs(x[N:] - x[:-N]) <= tolerance).all() and (s[N:] == s[:-N]).all())


def settling(x, N, arrived):
    """Whether points in units of the extents come back better and better after N steps, or have arrived.

    One point whose extent is 1e4 tolerances or less may be gone round by rounding alone.
    """
    if N == 1 and arrived.min() >= 1e-4:
        return True
    after = np.abs(x[N:] - x[:-N]).max(axis=1)
    worst = np.array([part.max() for part in np.array_split(after, min(4, len(after) // N))])
    if not ((worst[1:] < worst[:-1] * (1.0 - 1e-10)) | (worst[1:] <= arrived.max())).all():
        return False
    if N == 1 and x.shape[1] > 1:
        return True
    after_two = np.abs(x[-N:] - x[len(x) - 3 * N : len(x) - 2 * N]).max()
    return bool(min(worst[-1], after_two) <= 0.1)


def tangents(P, x, N):
    """The N-th iterate and the Jacobians of the N steps; None where something is not finite."""
    try:
        points = P.orbit(x, N).points
        matrices = [P.jacobian(point) for point in points[:-1]]
    except gz.InputError:
        return None
    if not (np.isfinite(points).all() and np.isfinite(matrices).all()):
        return None
    return points[-1], matrices


def turn_of(matrices):
    return reduce(lambda first, second: second @ first, matrices)


def kept_by(M):
    """The projector onto what M keeps, where all else contracts; else 0."""
    values, vectors = np.linalg.eig(M)
    ones = np.abs(values - 1.0) <= 1e-12
    if not ones.any() or not (np.abs(values[~ones]) < 1.0 - 1e-9).all():
        return np.zeros_like(M)
    return ((vectors * ones) @ np.linalg.inv(vectors)).real


def cycle_beside(P, state, letters, tolerance, steps=12):
    """A point of the cycle with these letters near a state, and the derivative of a turn from there; None for none."""
    x, N, first = state, len(letters), True
    for _ in range(steps):
        found = tangents(P, x, N)
        if found is None:
            return NO_TANGENT if first else None
        first = False
        end, matrices = found
        try:
            M = turn_of(matrices)
            move = np.linalg.solve(np.eye(len(x)) - M + kept_by(M), end - x)
        except np.linalg.LinAlgError:
            return None
        x = x + move
        if (np.abs(move) <= tolerance).all():
            break
    else:
        return None
    found = tangents(P, x, N)
    if found is None:
        return None
    orbit = P.orbit(x, N)
    shorter = [k for k in range(1, N) if N % k == 0 and (np.abs(orbit.points[k] - x) <= tolerance).all()]
    if shorter or (orbit.letters != letters).any():
        return None
    return x, turn_of(found[1])


def approaches(z, M, x, N, tolerance):
    """Whether points x fall towards the cycle through z, in coordinates along the eigenvectors of M."""
    _values, vectors = np.linalg.eig(M)
    radius = np.abs(np.linalg.eigvals(M - kept_by(M))).max()
    if not radius < 1.0 - 1e-9:
        return False
    frame = np.eye(len(M)) if np.linalg.cond(vectors) > 1e8 else np.linalg.inv(vectors)
    distances = np.abs((x[::-1][::N] - z) @ frame.T).max(axis=1)
    floor = (np.abs(frame) @ tolerance).max() / (0.5 * (1.0 - radius) if N == 1 else 1.0)
    falls = ((distances[:-2] < distances[2:]) | (distances[:-2] <= floor)).all()
    turns = (len(distances) - 1) // 2 * 2
    bound = distances[turns] * (1.0 - 0.1 * (1.0 - radius)) ** turns
    return bool(falls and distances[0] <= max(bound, floor))
