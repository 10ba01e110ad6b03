"""The ladder of reductions: how far each simplification moves the windows, and where the simplest map still holds.

Left, the error of the upper edge of each window on every rung, with the measured order of convergence; right, where
the gap map has the words of the oscillator in the plane of the offset and the kick.
Run it with `python examples/ladder.py`; it writes ladder.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Climb the ladder, draw it, and return the measured orders and the share of cells with the same words."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=int, default=9, help="largest period of a window")
    parser.add_argument("--size", type=int, default=160, help="cells a side of the validity map")
    parser.add_argument("--out", default="ladder.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    model = gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4)
    rungs = gz.ladder(model, "d", N=range(2, options.periods + 1))
    orders = {}
    for rung in rungs.rung.values.tolist()[:-1]:
        at = rungs.sel(rung=rung, side="high")
        orders[rung] = at.order.item()
        print(f"{rung:10s} order {orders[rung]:.3f} ± {at.order_error.item():.3f}, in theory {at.expected.item():g}")
    values = {"d": np.linspace(0.05, 0.14, options.size), "V": np.linspace(0.0, 0.6, options.size)}
    map_of = gz.validity(model, values, rung="gap")
    same = float((map_of.agreement == 0).mean())
    print(f"the gap map has the words of the flow in {same:.0%} of the cells")

    fig, (left, right) = gz.plot.panels(174, 72, columns=2)
    gz.plot.ladder(rungs, left, legend=False)
    gz.plot.validity(map_of, right)
    print(f"written: {gz.plot.save(fig, options.out)}")
    return orders, same


if __name__ == "__main__":
    main()
