"""Steps along a manifold: starts near a saddle taken n steps of the map forwards, or backwards through its inverse.

Each kind has ``further(leaves, n) -> Leaves``: what becomes of points in n steps more. The first are starts on a
straight line through the saddle. Forwards there is one for each start, or none. Backwards an oscillator is flown back
from contact to contact, through every branch of the inverse reset law; of any other map the preimage is solved for by
Newton's method along the curve.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map, swift
from grazing.orbits.backward import BACK, CLIMB, HEIGHT, HIT, Seen, flown_back, impacts_before

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Codes = NDArray[np.uint64]

#: Steps forwards whose letters are held at once.
CHUNK = 64
#: Impacts in one period beyond which a state is not followed back: a ball close to chatter.
MAX_IMPACTS = 20
#: A point k steps back must come to the one k - 1 steps back by one step of the map, to this relative error.
TOLERANCE = 1e-8
#: States this many sides of the box large are not followed back any more: the ball gains energy on the way.
HUGE = 1e12
#: Newton steps for one preimage, and parts of the way from a known one at which it is tried again.
NEWTON, PARTS = 12, 16
#: Step, in sides of the box, of the differences that stand for the derivative in Newton's method.
DIFFERENCE = 1e-6


class Leaves:
    """Points found: parameter ``t`` and distance ``seed`` of the start, a ``code`` of the history, state, letters.

    ``state`` is (n, 2), ``letters`` (n, order): those that the map writes on the way, in the order of time. Points of
    one code that are neighbours in t lie on one curve.
    """

    def __init__(self, t: Floats, seed: Floats, code: Codes, state: Floats, letters: NDArray[np.int32]) -> None:
        self.t, self.seed, self.code, self.state, self.letters = t, seed, code, state, letters

    def __len__(self) -> int:
        return len(self.t)

    def at(self, rows: Any) -> Leaves:
        """Return some of the rows."""
        return Leaves(self.t[rows], self.seed[rows], self.code[rows], self.state[rows], self.letters[rows])

    def with_more(self, other: Leaves) -> Leaves:
        """Return the rows of both."""
        return Leaves(
            np.concatenate([self.t, other.t]),
            np.concatenate([self.seed, other.seed]),
            np.concatenate([self.code, other.code]),
            np.concatenate([self.state, other.state]),
            np.concatenate([self.letters, other.letters]),
        )


class Ray(NamedTuple):
    """A straight line from a saddle: where it begins, its direction, one side of the box long."""

    start: Floats
    direction: Floats

    def at(self, seed: Floats) -> Floats:
        """Return the states (n, 2) at distances (n,)."""
        return np.asarray(self.start + seed[:, None] * self.direction)


class Steps(Protocol):
    """What a manifold is grown by."""

    ray: Ray

    def further(self, leaves: Leaves, n: int) -> Leaves:
        """Return what becomes of points in n steps more."""


def traced(steps: Steps, t: Floats, seed: Floats, order: int) -> Leaves:
    """Return what becomes of starts at distances ``seed`` (n,), of parameters ``t`` (n,), in ``order`` steps."""
    none = np.zeros(len(t), np.uint64), steps.ray.at(seed), np.empty((len(t), 0), np.int32)
    return steps.further(Leaves(t, seed, *none), order)


def mixed(code: Codes, letter: Any) -> Codes:
    """Return a number that stands for a history with one letter more (a multiplicative hash)."""
    new = (code + np.asarray(letter).astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    return np.asarray(new ^ (new >> np.uint64(29)), np.uint64)


def stepped(P: Map, state: Floats, n: int) -> tuple[Floats, NDArray[np.int32]]:
    """Return states (m, 2) n steps later, NaN where an orbit ended, and their letters (m, n)."""
    if len(state) == 0:
        return state, np.empty((0, n), np.int32)
    lanes, letters = np.array(state.T, np.float64, order="C"), [np.empty((0, len(state)), np.int64)]
    while n > 0:
        _points, some, _outcomes = P.run(lanes, 0, min(n, CHUNK))
        letters.append(some)
        n -= CHUNK
    return lanes.T.copy(), np.concatenate(letters).T.astype(np.int32)


class Forwards:
    """The map itself."""

    def __init__(self, P: Map, ray: Ray) -> None:
        self.map, self.ray = swift(P), ray

    def further(self, leaves: Leaves, n: int) -> Leaves:
        """Return what becomes of points in n steps more."""
        state, letters = stepped(self.map, leaves.state, n)
        code, every = leaves.code, np.column_stack([leaves.letters, letters])
        for k in range(n):
            code = mixed(code, letters[:, k])
        return Leaves(leaves.t, leaves.seed, code, state, every).at(np.isfinite(state).all(axis=1))


class Flown(NamedTuple):
    """States flown back one period: which state before each comes from, its code, the state, the impacts between."""

    origin: Ints
    code: Codes
    state: Floats
    letter: Ints


class Backwards:
    """The inverse of the stroboscopic map of an oscillator, with all its branches."""

    def __init__(self, P: Map, ray: Ray, sides: Floats) -> None:
        assert P.model is not None
        self.map, self.model, self.ray, self.sides = swift(P), P.model, ray, sides
        self.seen = Seen.at(P.model, P.params["phase"])

    def further(self, leaves: Leaves, n: int) -> Leaves:
        """Return every state from which n steps of the map lead to one of the points."""
        back = [Flown(np.arange(len(leaves)), leaves.code, leaves.state, np.zeros(len(leaves), np.int64))]
        for _ in range(n):
            back.append(self.before(back[-1]))
        good = self.returning(back)
        rows = np.flatnonzero(good[-1])
        code, state = back[-1].code[rows], back[-1].state[rows]
        letters = np.empty((len(rows), n), np.int32)
        for k in range(n, 0, -1):  # the last step back is the first letter
            letters[:, n - k] = back[k].letter[rows]
            rows = back[k].origin[rows]
        from_here = leaves.at(rows)
        return Leaves(from_here.t, from_here.seed, code, state, np.column_stack([letters, from_here.letters]))

    def returning(self, back: list[Flown]) -> list[NDArray[np.bool_]]:
        """Return which states, step by step, the map takes back to where they came from."""
        every = np.concatenate([one.state for one in back])
        later, letters = stepped(self.map, every, 1)
        good, done = [np.ones(len(back[0].state), bool)], len(back[0].state)
        for before, one in itertools.pairwise(back):
            here = slice(done, done + len(one.state))
            aim = before.state[one.origin]
            error = np.abs((later[here] - aim) / self.sides).max(axis=1, initial=0.0)
            comes = error <= TOLERANCE * (1.0 + np.abs(aim / self.sides).max(axis=1, initial=0.0))
            good.append(comes & (letters[here, 0] == one.letter) & good[-1][one.origin])
            done += len(one.state)
        return good

    def before(self, one: Flown) -> Flown:
        """Fly back one period."""
        sigma = self.model.sigma
        lines = np.zeros((len(one.state), 4))
        lines[:, HEIGHT], lines[:, CLIMB] = one.state[:, 0] - sigma, -one.state[:, 1]
        lines[:, BACK] = 0.0
        origin, code = np.arange(len(one.state)), one.code
        done = []
        for count in range(MAX_IMPACTS + 1):
            flown_back(self.seen, lines)
            hit = lines[:, HIT] > 0.0
            ended = lines[~hit]
            state = np.column_stack([ended[:, HEIGHT] + sigma, -ended[:, CLIMB]])
            done.append(Flown(origin[~hit], code[~hit], state, np.full(len(ended), count)))
            lines, origin, code = lines[hit], origin[hit], code[hit]
            speeds = impacts_before(self.seen, -lines[:, CLIMB])
            i, branch = np.nonzero(speeds > 0.0)
            if len(i) == 0:
                break
            lines, origin, code = lines[i], origin[i], mixed(code[i], branch)
            lines[:, CLIMB] = speeds[i, branch]
        found = Flown(*(np.concatenate(column) for column in zip(*done, strict=True)))
        good = (np.abs(found.state / self.sides) < HUGE).all(axis=1)
        return Flown(found.origin[good], mixed(found.code[good], 1_000_003), found.state[good], found.letter[good])


class Solved:
    """Preimages of any map by Newton's method, each from the nearest one known on the curve.

    ``known[k]`` holds the curve k steps back so far: distances of the starts, increasing, states, and their images.
    It begins at ``anchor(k)``, a state on it, or next to it, before anything is known; None where there is none.
    """

    def __init__(self, P: Map, ray: Ray, sides: Floats, anchor: Callable[[int], Floats | None]) -> None:
        self.map, self.ray, self.sides, self.anchor = swift(P), ray, sides, anchor
        self.known: dict[int, tuple[Floats, Floats, Floats]] = {}

    def further(self, leaves: Leaves, n: int) -> Leaves:
        """Return the states that come to the points in n steps and are connected to what is known."""
        for _ in range(n):
            state = self.before(leaves.seed, leaves.state, leaves.letters.shape[1] + 1)
            good = np.isfinite(state).all(axis=1)
            leaves, state = leaves.at(good), state[good]
            letter = stepped(self.map, state, 1)[1]
            code, letters = mixed(leaves.code, letter[:, 0]), np.column_stack([letter, leaves.letters])
            leaves = Leaves(leaves.t, leaves.seed, code, state, letters)
        return leaves

    def before(self, seed: Floats, target: Floats, k: int) -> Floats:
        """Return a preimage of each target (n, 2) on the curve k steps back, NaN where none is connected to it."""
        found = np.full_like(target, np.nan)
        if len(seed) == 0:
            return found
        if k in self.known:
            seeds, states, images = self.known[k]
            if len(seeds):
                right = np.clip(np.searchsorted(seeds, np.abs(seed)), 0, len(seeds) - 1)
                left = np.maximum(right - 1, 0)
                near = np.where(np.abs(seeds[left] - np.abs(seed)) < np.abs(seeds[right] - np.abs(seed)), left, right)
                found = self.led(states[near], images[near], target)
                self.keep(k, seed, found, target)
            return found
        first = self.anchor(k)
        if first is not None:
            state, image = first[None], stepped(self.map, first[None], 1)[0]
            for i in range(len(seed)):  # from one to the next
                found[i] = self.led(state, image, target[i : i + 1])[0]
                if np.isfinite(found[i]).all():
                    state, image = found[i : i + 1], target[i : i + 1]
        self.keep(k, seed, found, target)
        return found

    def keep(self, k: int, seed: Floats, state: Floats, image: Floats) -> None:
        """Add what was found k steps back."""
        old = self.known.get(k, (np.empty(0), np.empty((0, 2)), np.empty((0, 2))))
        good = np.isfinite(state).all(axis=1)
        every = [np.concatenate([a, b[good]]) for a, b in zip(old, (np.abs(seed), state, image), strict=True)]
        _unique, rows = np.unique(every[0], return_index=True)
        self.known[k] = every[0][rows], every[1][rows], every[2][rows]

    def led(self, state: Floats, image: Floats, target: Floats) -> Floats:
        """Return preimages of targets from those of images: at once, or where that fails step by step."""
        found = self.newton(state, target)
        for i in np.flatnonzero(~np.isfinite(found).all(axis=1)):
            here = state[i : i + 1]
            for part in range(1, PARTS + 1):
                share = part / PARTS
                here = self.newton(here, (1.0 - share) * image[i : i + 1] + share * target[i : i + 1])
                if not np.isfinite(here).all():
                    break
            found[i] = here[0]
        return found

    def newton(self, guess: Floats, target: Floats) -> Floats:
        """Return states whose image is the target, from guesses; NaN where Newton's method does not get there."""
        state, n = guess.copy(), len(guess)
        h = DIFFERENCE * self.sides
        shifts = h * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        best, least = state.copy(), np.full(n, np.inf)
        for _ in range(NEWTON):
            beside = (state[None] + shifts[:, None]).reshape(-1, 2)
            images = stepped(self.map, beside, 1)[0].reshape(5, n, 2)
            defect = images[0] - target
            error = np.abs(defect / self.sides).max(axis=1)
            better = error < least
            best[better], least[better] = state[better], error[better]
            a, b = (images[1] - images[2]) / (2.0 * h[0]), (images[3] - images[4]) / (2.0 * h[1])
            det = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                step = np.column_stack(
                    [defect[:, 0] * b[:, 1] - defect[:, 1] * b[:, 0], a[:, 0] * defect[:, 1] - a[:, 1] * defect[:, 0]]
                )
                state = state - step / det[:, None]
            if not ((least > 1e-15) & np.isfinite(state).all(axis=1)).any():
                break
        scale = 1.0 + np.abs(target / self.sides).max(axis=1)
        best[~(least <= TOLERANCE * 1e-3 * scale)] = np.nan
        return best
