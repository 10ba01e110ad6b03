"""Physics engines and an event-driven billiard on the tables of :mod:`benchmarks.pinball`: their speed, what they miss.

Engines take steps of time and look for overlaps; they know no ball without a size, so that discs are smaller and walls
farther off by its radius here. Their own impacts are counted, right or wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from time import process_time
from typing import Any

import numpy as np

from .models import Array
from .program import peer

WIDTH, HEIGHT, RADIUS = 6.0, 10.0, 0.5
CORNERS = ((0.0, 0.0), (WIDTH, 0.0), (WIDTH, HEIGHT), (0.0, HEIGHT))
#: Radius of the ball and seconds of a step of engines, and simulated seconds of a measurement.
BALL, STEP, SECONDS = 0.05, 1e-3, 20.0
#: Where a ball passes a disc, at the highest point of its flight: the disc, the speed there, the time until then.
DISC, PASSING, BEFORE = (3.0, 5.0), 2.0, 0.7
#: By how much it overlaps the disc there.
DEPTHS = 10.0 ** -np.linspace(3.0, 13.0, 40)

#: ``program(discs, share) -> collisions a second``, and ``hits(depth) -> whether a pass of that depth is an impact``.
Program = Callable[[int, float], float]
Hits = Callable[[float], bool]


def pass_over(depth: float, g: float = 1.0) -> tuple[float, float, float, float]:
    """Return the state of a ball whose flight overlaps the disc by a depth at its highest point, and nowhere more.

    It stays clear of the disc where that is negative.
    """
    t = BEFORE * (1.0 + 0.1 * np.sin(1e3 * np.log(abs(depth))))  # at no fixed place of a step
    return DISC[0] - PASSING * t, DISC[1] + RADIUS - depth - 0.5 * g * t * t, PASSING, g * t


def judged(hits: Hits) -> str:
    """Return how many passes are missed, and how many of those that stay clear are taken for impacts."""
    missed, false = (sum(hits(sign * depth) != (sign > 0.0) for depth in DEPTHS.tolist()) for sign in (1.0, -1.0))
    return f"{missed}, {false} of {len(DEPTHS)}"


def fastest() -> float:
    """Return the speed with which all programs launch, just under the ceiling."""
    return sqrt(2.0 * (12.0 - (HEIGHT - 0.2)))


def in_pymunk() -> tuple[Program, Hits]:
    """Return pymunk (Chipmunk)."""
    pymunk = peer("pymunk")

    def world(centres: Array, state: tuple[float, ...]) -> tuple[Any, list[int]]:
        space, seen = pymunk.Space(), [0]
        space.gravity = 0.0, -1.0
        body = pymunk.Body(1.0, float("inf"))
        body.position, body.velocity = state[:2], state[2:]
        ball = pymunk.Circle(body, BALL)
        fixed = [pymunk.Circle(space.static_body, RADIUS - BALL, tuple(place)) for place in centres.tolist()]
        outer = [(x + (BALL if x else -BALL), y + (BALL if y else -BALL)) for x, y in CORNERS]
        fixed += [pymunk.Segment(space.static_body, outer[i], outer[(i + 1) % 4], 0.0) for i in range(4)]
        for one in (ball, *fixed):
            one.elasticity, one.friction = 1.0, 0.0
        space.add(body, ball, *fixed)

        def begin(*_of: Any) -> None:
            seen[0] += 1

        space.on_collision(begin=begin)
        return space, seen

    def run(space: Any, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            space.step(STEP)

    return counted(world, run)


def in_box2d() -> tuple[Program, Hits]:
    """Return Box2D, the ball as a bullet."""
    box2d = peer("Box2D")

    class Listener(box2d.b2ContactListener):  # type: ignore[misc, name-defined]
        def __init__(self, seen: list[int]) -> None:
            super().__init__()
            self.seen = seen

        def BeginContact(self, contact: Any) -> None:
            self.seen[0] += 1

    def world(centres: Array, state: tuple[float, ...]) -> tuple[Any, list[int]]:
        seen = [0]
        found = box2d.b2World(gravity=(0.0, -1.0), contactListener=Listener(seen))
        for place in centres.tolist():
            circle = box2d.b2CircleShape(pos=tuple(place), radius=RADIUS - BALL)
            found.CreateStaticBody(fixtures=box2d.b2FixtureDef(shape=circle, restitution=1.0, friction=0.0))
        outer = [(x + (BALL if x else -BALL), y + (BALL if y else -BALL)) for x, y in CORNERS]
        for i in range(4):
            edge = box2d.b2EdgeShape(vertices=[outer[i], outer[(i + 1) % 4]])
            found.CreateStaticBody(fixtures=box2d.b2FixtureDef(shape=edge, restitution=1.0, friction=0.0))
        shape = box2d.b2CircleShape(radius=BALL)
        ball = box2d.b2FixtureDef(shape=shape, density=1.0, restitution=1.0, friction=0.0)
        found.CreateDynamicBody(
            position=state[:2],
            linearVelocity=state[2:],
            bullet=True,
            fixedRotation=True,
            allowSleep=False,
            fixtures=ball,
        )
        return found, seen

    def run(found: Any, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            found.Step(STEP, 8, 3)

    return counted(world, run)


def counted(world: Callable[..., Any], run: Callable[[Any, float], None]) -> tuple[Program, Hits]:
    """Return speed and passes of an engine from what makes a world and lets time pass in it."""
    from .pinball import places

    def program(count: int, share: float) -> float:
        angle = 1.0
        space, seen = world(places(count), (0.2, HEIGHT - 0.2, fastest() * np.cos(angle), fastest() * np.sin(angle)))
        before = process_time()
        run(space, max(SECONDS * share, 0.5))
        return float(seen[0]) / (process_time() - before)

    def hits(depth: float) -> bool:
        space, seen = world(np.array([DISC]), pass_over(depth))
        run(space, 2.0 * BEFORE)
        return bool(seen[0])

    return program, hits


def in_billiards() -> tuple[Program, Hits]:
    """Return the package billiards: from impact to impact, without gravity."""
    billiards = peer("billiards")

    def world(centres: Array, state: tuple[float, ...]) -> Any:
        walls = [billiards.InfiniteWall(CORNERS[i], CORNERS[(i + 1) % 4]) for i in range(4)]
        found = billiards.Billiard(obstacles=[*walls, *(billiards.Disk(place, RADIUS) for place in centres.tolist())])
        found.add_ball(state[:2], state[2:])
        return found

    def program(count: int, share: float) -> float:
        from .pinball import places

        found = world(places(count), (0.2, HEIGHT - 0.2, fastest() * np.cos(1.0), fastest() * np.sin(1.0)))
        before = process_time()
        seen = len(found.evolve(10.0 * SECONDS * share + 5.0))
        return seen / (process_time() - before)

    def hits(depth: float) -> bool:
        found = world(np.array([DISC]), pass_over(depth, 0.0))
        return bool(found.evolve(1.2 * BEFORE))

    return program, hits
