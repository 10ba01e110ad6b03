"""Which solvers survive chatter: a ball dropped on the floor from height 1, followed until t = 60.

It bounces infinitely often in a finite time and then lies still: u'' = -1, v -> -r v, at rest from
sqrt(2) (1 + r)/(1 - r) on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rich.console import Console

import grazing as gz

from .program import Missing, foreign, peer
from .table import show

UNTIL = 60.0
BUDGET = 3000  # impacts after which a loop around a solver gives up
RATIOS = (0.5, 0.8, 0.95)


class Followed(NamedTuple):
    """How far a program followed the ball: impacts, time reached, height there (exactly 0) and its own comment."""

    impacts: int
    time: float
    height: float
    comment: str


class Chatter(NamedTuple):
    """One program and one coefficient of restitution; ``rest`` is when the ball comes to rest."""

    name: str
    r: float
    rest: float
    followed: Followed | None
    missing: str = ""


def scipy(r: float) -> Followed:
    """Follow the ball with solve_ivp, started again after each impact."""
    from scipy.integrate import solve_ivp

    def motion(t: float, state: Any) -> tuple[float, float]:
        return state[1], -1.0

    def wall(t: float, state: Any) -> float:
        return float(state[0])

    wall.terminal = True  # type: ignore[attr-defined]
    wall.direction = -1  # type: ignore[attr-defined]
    t, u, v = 0.0, 1.0, 0.0
    for impacts in range(BUDGET):
        run = solve_ivp(motion, (t, UNTIL), (u, v), method="DOP853", rtol=1e-9, atol=1e-12, events=wall)
        t, (u, v) = float(run.t[-1]), run.y[:, -1].tolist()
        if run.status != 1:
            return Followed(impacts, t, u, run.message)
        u, v = 0.0, -r * v
    return Followed(BUDGET, t, u, f"stopped by us after {BUDGET} impacts")


def heyoka(r: float) -> Followed:
    """Follow the ball with heyoka."""
    hy = peer("heyoka")
    u, v = hy.make_vars("u", "v")
    impacts = 0

    def impact(solver: Any, sign: int) -> bool:
        nonlocal impacts
        impacts += 1
        solver.state[:] = 0.0, -r * solver.state[1]
        return True

    wall = hy.t_event(u, direction=hy.event_direction.negative, callback=impact)
    solver = hy.taylor_adaptive([(u, v), (v, hy.expression(-1.0))], state=[1.0, 0.0], t_events=[wall])
    outcome = solver.propagate_until(UNTIL)[0]
    return Followed(impacts, solver.time, float(solver.state[0]), str(outcome).rpartition(".")[2])


def grazing(r: float) -> Followed:
    """Follow the ball with gz.trajectory."""
    still = gz.Forcing(omega=1.0, offset=-1.0, cos=(0.0,))
    ball = gz.trajectory(
        gz.Oscillator(alpha=0.0, k=0.0, forcing=still, reset=gz.newton(r=r)), (1.0, 0.0), start=0.0, until=UNTIL
    )
    outcome = gz.Outcome(ball.attrs["grazing_outcome"]).name or ""
    said = ", ".join([ball.trust.item(), *outcome.lower().split("|")])
    return Followed(ball.sizes["impact"], float(ball.t[-1]), float(ball.u[-1]), said)


FOLLOWERS: dict[str, Callable[[float], Followed]] = {
    "SciPy DOP853, restarted": scipy,
    "heyoka": heyoka,
    "grazing": grazing,
}


def chatter(names: Sequence[str], tell: Callable[[str], None]) -> list[Chatter]:
    """Follow the ball with these programs, for every coefficient of restitution."""
    found = []
    for name in names:
        for r in RATIOS:
            tell(f"chatter: {name}, r = {r}")
            rest = math.sqrt(2.0) * (1.0 + r) / (1.0 - r)
            try:
                with foreign():
                    found.append(Chatter(name, r, rest, FOLLOWERS[name](r)))
            except Missing as reason:
                found.append(Chatter(name, r, rest, None, str(reason)))
    return found


def show_bounces(out: Console, found: Sequence[Chatter]) -> None:
    """Print what programs do with infinitely many impacts."""
    head = ("program", "r", "at rest from", "impacts", "until t", "height there", "it says")
    lines = []
    for name, r, rest, followed, missing in found:
        if followed is None:
            lines.append((f"{name} ({missing})", f"{r:g}", f"{rest:.5g}", "", "", "", ""))
        else:
            impacts, time, height, comment = followed
            lines.append((name, f"{r:g}", f"{rest:.5g}", str(impacts), f"{time:.5g}", f"{height:.5g}", comment))
    show(out, "Chatter: a ball dropped on the floor from height 1, followed until t = 60", head, lines)
