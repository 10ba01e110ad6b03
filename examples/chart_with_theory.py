"""A chart of the bumper in d and V: the period that most starts reach, and the exact edges of the windows on top.

Cells with more than one attractor are striped. The lines are the edges of the windows of one-impact orbits, from
closed forms and not from the cells.
Run it with `python examples/chart_with_theory.py`; it writes chart_with_theory.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Compute and draw the chart, and return the share of cells in which several attractors coexist."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=240, help="cells a side")
    parser.add_argument("--out", default="chart_with_theory.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    P = gz.stroboscopic_map(gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4))
    d, V = (0.06, 0.14), (0.05, 0.6)
    chart = gz.chart(P, {"d": np.linspace(*d, options.size), "V": np.linspace(*V, options.size)})
    edges = gz.boundaries(P, ("d", *d), ("V", *V), N=range(2, 5))
    curves = {}
    for label, x, y in zip(edges.label.values, edges.d.values, edges.V.values, strict=True):
        before = curves.get(label, (np.empty(0), np.empty(0)))  # edges of one name are one line in pieces
        curves[label] = np.append(before[0], [np.nan, *x]), np.append(before[1], [np.nan, *y])
    several = float((chart.share[:, :, 1] > 0).mean())
    print(f"{several:.1%} of the cells have more than one attractor; {len(curves)} edges from closed forms")
    print(f"written: {gz.plot.save(gz.plot.chart(chart, curves=curves), options.out)}")
    return several


if __name__ == "__main__":
    main()
