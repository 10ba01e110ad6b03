"""What separates basins: the stable manifolds of the saddles between the attractors.

Three motions of this ball are stable: one that never hits the wall, and one with an impact every second and every
third period of the forcing. Between them lie two saddles with the same words. States on the stable manifold of a
saddle come to the saddle, those next to it leave it to one side or the other: the manifolds, computed from the two
orbits alone, are the boundaries that the basins show pixel by pixel.
Run it with `python examples/manifolds.py`; it writes manifolds.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Grow the manifolds on top of the basins, and return the length of each inside the figure, in its sides."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=500, help="cells a side")
    parser.add_argument("--length", type=float, default=2.0, help="of each branch, at most, in sides of the figure")
    parser.add_argument("--out", default="manifolds.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    model = gz.pinball(alpha=0.1, k=1, omega=3.27, d=0.57, r=0.9, V=0.1)
    box = (0.0, 1.4), (-1.8, 1.8)
    grid = {name: np.linspace(*side, options.size) for name, side in zip("uv", box, strict=True)}
    drawn = gz.plot.basins(gz.basins(gz.stroboscopic_map(model), grid, preimages=0))
    ax = drawn["figure"].axes[0]
    lengths = {}
    for N in (2, 3):
        saddles = [o for o in gz.one_impact_orbits(model, N) if o.admissible and o.multipliers[0].real > 1.0]
        for saddle in saddles:
            grown = gz.manifolds(saddle, "stable", length=options.length, box=box)
            gz.plot.manifolds(grown, ax)
            lengths[saddle.word] = float(grown.branch_length.sum())
            print(f"{saddle}: multipliers {saddle.multipliers.real.round(4)}, {grown.sizes['piece']} pieces")
    print(f"written: {gz.plot.save(drawn, options.out)}")
    return lengths


if __name__ == "__main__":
    main()
