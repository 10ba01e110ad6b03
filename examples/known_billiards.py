"""Two billiards whose laws are known: a Sinai billiard with small discs, and the fall down a Galton board.

Left, the Lyapunov exponent per collision of a ball among discs of radius R, one in each square of a lattice: it is
-2 ln R + 1 - 4 ln 2 + 27 zeta(3)/(2 pi^2) + o(1) for small R. A square of mirrors around one disc is this lattice,
unfolded. Right, a ball under gravity among elastic discs in a triangular lattice without free ways: its speed grows as
t^(1/3), its fall as t^(2/3) (Chernov and Dolgopyat, 2009). Gravity is the same on both sides of a vertical mirror line,
so a strip between two of those is this board, unfolded.
Run it with `python examples/known_billiards.py`; it writes known_billiards.png.
"""

import argparse
from math import ceil, log, pi, sqrt

import numpy as np

import grazing as gz

ELASTIC = gz.newton(1.0)
#: Starts of an exponent, those that are kept in memory at a time, and steps before anything is summed.
STARTS, GROUP, WARM = 256, 64, 64
#: lambda + 2 ln R as R goes to 0.
CONSTANT = 1.0 - 4.0 * log(2.0) + 27.0 * 1.2020569031595942 / (2.0 * pi**2)


def sinai(radius, starts, hits):
    """Return lambda + 2 ln R per collision with a disc and its error, of so many starts and collisions of each."""
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    mirrors = [gz.segment(f"mirror{i}", corners[i], corners[(i + 1) % 4], ELASTIC) for i in range(4)]
    P = gz.collision_map(gz.table([gz.disc("disc", (0.5, 0.5), radius, ELASTIC), *mirrors]))
    steps = round(hits * (1.0 + 2.0 / (pi * radius)))  # mirrors have 2/(pi R) times the length of the circle
    random, total, struck = np.random.default_rng(0), [], []
    for _ in range(0, starts, GROUP):
        place, sine = random.uniform(0, 2 * pi * radius, GROUP), random.uniform(-1, 1, GROUP)
        state = np.array([place, np.arcsin(sine), np.ones(GROUP)])
        found = gz.lyapunov(P, starts=state.T, transient=0, steps=steps, arithmetic="strict")
        total.append(found.exponent.values[:, 0] * steps)
        struck.append((P.run(state, WARM, steps)[1] == 0).sum(axis=0))  # of the same steps
    total, struck = np.concatenate(total), np.concatenate(struck)
    exponent = total.sum() / struck.sum()
    error = (total - exponent * struck).std(ddof=1) * sqrt(len(total)) / struck.sum()
    return exponent + 2.0 * log(radius), error


def board(depth, radius=0.45):
    """Return a strip of a Galton board so deep: discs on its mirror lines are cut in halves by them."""
    things, row = [], sqrt(3.0)
    for k in range(ceil(depth / row) + 1):
        y = -k * row
        things.append(gz.disc(f"middle{k}", (0.5, y - 0.5 * row), radius, ELASTIC))
        for side, x in (("left", 0.0), ("right", 1.0)):
            things.append(gz.disc(f"{side}{k}", (x, y), radius, ELASTIC))
            things.append(gz.segment(f"{side}_mirror{k}", (x, y - radius), (x, y - row + radius), ELASTIC))
    things.append(gz.segment("lid", (radius, 0.0), (1.0 - radius, 0.0), ELASTIC))
    bottom = y - row + radius
    return gz.table([*things, gz.drain("out", (0.0, bottom), (1.0, bottom))], tilt=0.5 * pi)


def fall(table, balls, times):
    """Return speed and fall of balls at times, shape (balls, times); they fall from where they would be at rest."""
    random, found = np.random.default_rng(1), np.empty((2, balls, len(times)))
    for i in range(balls):
        angle, t, y, speed = random.uniform(0.0, 2.0 * pi), 0.0, -0.25, 0.5
        state = 0.5, y, speed * np.cos(angle), speed * np.sin(angle)
        for j, until in enumerate(times):
            flown = gz.trajectory(table, state, start=t, until=until, samples=2)
            if flown.attrs["outcome"] != "ok":
                raise RuntimeError(f"a ball {flown.attrs['outcome']} before t = {until:g}; make the board deeper")
            state, t = [flown[name].values[-1] for name in ("x", "y", "vx", "vy")], until
            found[:, i, j] = np.hypot(state[2], state[3]), y + 0.5 * speed * speed - state[1]
    return found


def exponents(values, times):
    """Return the powers of time with which the mean grows from decade to decade, and their errors by resampling."""

    def powers(chosen):
        return np.diff(np.log(chosen.mean(axis=0)[::2])) / np.diff(np.log(times[::2]))

    random = np.random.default_rng(2)
    again = [powers(values[random.integers(0, len(values), len(values))]) for _ in range(400)]
    return powers(values), np.std(again, axis=0)


def main(tokens=None):
    """Measure both, draw them, and return the constants with errors by radius, and the exponents with errors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--radii", type=float, nargs="+", default=[0.1, 0.03, 0.01, 0.003], help="of the Sinai billiards"
    )
    parser.add_argument("--hits", type=int, default=150, help="collisions with a disc of each of 256 starts")
    parser.add_argument("--balls", type=int, default=200, help="balls on the Galton board")
    parser.add_argument("--until", type=float, default=300.0, help="time of the fall")
    parser.add_argument("--out", default="known_billiards.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    constants = {radius: sinai(radius, STARTS, options.hits) for radius in options.radii}
    for radius, (value, error) in constants.items():
        print(f"R = {radius:<6g} lambda + 2 ln R = {value:.4f} ± {error:.4f}; {CONSTANT:.4f} for R to 0")
    times = np.geomspace(options.until / 100.0, options.until, 5)
    speeds, falls = fall(board(2.2 * options.until ** (2.0 / 3.0) + 20.0), options.balls, times)
    grown = {"speed": exponents(speeds, times), "fall": exponents(falls, times)}
    for name, (power, error) in grown.items():
        said = ", then ".join(f"{p:.3f} ± {e:.3f}" for p, e in zip(power, error, strict=True))
        print(f"{name:5s} grows with the power {said} of time")

    fig, (left, right) = gz.plot.panels(174, 72, columns=2)
    values = np.array(list(constants.values()))
    left.errorbar(options.radii, values[:, 0], 2.0 * values[:, 1], fmt=".", ms=3, lw=0.8)
    left.axhline(CONSTANT, lw=0.6, color="black")
    left.set(xscale="log", xlabel="radius of the discs", ylabel="λ + 2 ln R")
    for values, power, name in ((speeds, 1.0 / 3.0, "speed"), (falls, 2.0 / 3.0, "fall")):
        mean = values.mean(axis=0)
        right.loglog(times, mean, ".", ms=4, label=name)
        right.loglog(times, mean[-1] * (times / times[-1]) ** power, lw=0.6, color="black")
    right.set(xlabel="time", ylabel="mean")
    right.legend(frameon=False)
    print(f"written: {gz.plot.save(fig, options.out)}")
    return constants, grown


if __name__ == "__main__":
    main()
