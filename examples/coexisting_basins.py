"""Basins of the bumper where an orbit of period 2 and one of period 3 are both stable.

Which of them the ball settles on depends on how it starts. The boundary follows the states that graze the wall, and
those that come to them later: the lines on the figure.
Run it with `python examples/coexisting_basins.py`; it writes coexisting_basins.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Compute and draw the basins, and return the fraction of each word."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=500, help="cells a side")
    parser.add_argument("--out", default="coexisting_basins.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    P = gz.stroboscopic_map(gz.pinball(alpha=3, k=1, omega=2.2, d=0.1, r=0.8, V=0.4))
    grid = {"u": np.linspace(0.0, 0.35, options.size), "v": np.linspace(-0.5, 0.6, options.size)}
    found = gz.basins(P, grid, preimages=3)
    for word, period, fraction in zip(found.word.values, found.period.values, found.fraction.values, strict=True):
        print(f"word {word}, period {period}: {fraction:.1%} of the states")
    print(f"basin entropy {found.basin_entropy:.4f}, dimension of the boundary {found.boundary_dimension:.3f}")
    print(f"written: {gz.plot.save(gz.plot.basins(found), options.out)}")
    return dict(zip(found.word.values.tolist(), found.fraction.values.tolist(), strict=True))


if __name__ == "__main__":
    main()
