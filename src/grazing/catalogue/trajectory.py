"""A motion in continuous time, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import runs
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import RANGES, aligned, between, headed, of, short

#: Impacts that are listed.
FIRST = 5

Array = Any


def found(result: Any) -> Row:
    """Return the number of impacts, the first of them, the rests on the wall and how far to trust them."""
    names = "impact_time", "v_minus", "v_plus"
    first = zip(*(result[name].values[:FIRST].tolist() for name in names), strict=True)
    of = "u" if "u" in result else str(result["coordinate"].values[0])  # a system of one's own has other names
    t, u = result["t"].values, result[of].values
    if of != "u":
        lies = []
    elif "rest_time" in result:  # of several walls, or one that moves
        lies = result["rest_time"].values.tolist()
    else:
        wall = float(result["wall"]) if "wall" in result else float(result.attrs.get("parameter_sigma", 0.0))
        lies = rests(t, u, result["v"].values, wall)
    said: Row = {
        "impacts": int(result.sizes["impact"]),
        "first": [dict(zip(("t", "v_minus", "v_plus"), impact, strict=True)) for impact in first],
        "coordinate": of,
        of: [float(u.min()), float(u.max())],
        "rests": lies,
        "chatter": bool(result.attrs.get("chatter", 0)),
        "trust": str(result["trust"].values),
        "exit": str(result["exit"].values) if "exit" in result else "",
        "end": float(t[-1]),
    }
    if said["impacts"]:
        speeds = result["impact_speed"].values if "impact_speed" in result else -result["v_minus"].values
        said["speeds"] = [float(speeds.min()), float(speeds.max())]
    return said


def rests(t: Array, u: Array, v: Array, wall: float) -> list[list[float]]:
    """Return when the ball lies on the wall, each time by its begin and end."""
    return [[float(t[i]), float(t[j - 1])] for i, j in runs((u == wall) & (v == 0.0)) if t[j - 1] > t[i]]


def words(found: Row, *_of: Any) -> list[str]:
    """Return the impacts, the rests and the trust."""
    count = found["impacts"]
    said = [f"{count or 'no'} impact{'' if count == 1 else 's'}, {found['trust']}"]
    rows = [[short(row[key]) for key in ("t", "v_minus", "v_plus")] for row in found["first"]]
    t, v = of("t", found), of("v", found)
    said += aligned([headed("impact at t", t), headed("v before", v), headed("v after", v)], rows) if rows else []
    if count > len(rows):
        said.append(f"and {count - len(rows)} more; speeds before impact {between(found['speeds'])} {v}".rstrip())
    if found["exit"]:
        said.append(f"left by {found['exit']} at t = {short(found['end'])}")
    if found["chatter"]:
        said.append("chatter: impacts without end in a finite time, completed in closed form")
    if found["rests"]:
        spans = ", ".join(between(span) for span in found["rests"][:RANGES])
        times = f"rests on the wall {len(found['rests'])} times, t = {spans} {t}".rstrip()
        said.append(times.replace(" 1 times", " once"))
    name = found["coordinate"]
    return [*said, f"{name} {between(found[name])} {of(name, found)}".rstrip() + " at the instants of the table"]


STUDY = Study(
    name="trajectory", place=70, compute="grazing.oscillator.trajectory:trajectory", of="model",
    says="one orbit in time, with every impact",
    help="Follow the ball in continuous time, with every impact.",
    example="u=0.1 v=0 --until 50 -o orbit.png",
    prints="the number of impacts and the first five, chatter, rests on the wall, whether it is certified",
    found=found, words=words, tables=True,
)  # fmt: skip
