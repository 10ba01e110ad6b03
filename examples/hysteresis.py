"""Hysteresis: orbits carried up and down in d settle on different periods where windows overlap.

Each value begins where its neighbour ended, as in an experiment with a slowly turned knob.
Run it with `python examples/hysteresis.py`; it writes hysteresis.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Draw the sweep up above the sweep down, and return the values of d at which they differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=600, help="values of d")
    parser.add_argument("--out", default="hysteresis.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    model = gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4)
    P = gz.stroboscopic_map(model)
    d = np.linspace(0.09, 0.132, options.values)
    fig, panels = gz.plot.panels(174, 120, rows=2, sharex=True)
    periods = {}
    for sweep, ax in zip(("up", "down"), panels, strict=True):
        diagram = gz.orbit_diagram(P, "d", d, starts=1, transient=300, keep=60, sweep=sweep)
        gz.plot.orbit_diagram(diagram, ax)
        ax.set_title(f"d carried {sweep}")
        periods[sweep] = diagram.period[:, 0].values

    differ = d[periods["up"] != periods["down"]]
    overlaps = gz.windows(model, "d", N=range(2, 6), span=(0.05, 0.14))
    print(f"{differ.size} of {d.size} values settle on another period on the way down, from d = {differ.min():.5f}")
    for N in range(2, 5):
        high = float(overlaps.high[(overlaps.N == N).values][0])
        low = float(overlaps.low[(overlaps.N == N + 1).values][0])
        print(f"periods {N} and {N + 1} are both stable for {low:.6f} < d < {high:.6f}")
    print(f"written: {gz.plot.save(fig, options.out)}")
    return differ


if __name__ == "__main__":
    main()
