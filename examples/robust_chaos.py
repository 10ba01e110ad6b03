"""Robust chaos of the gap map without a gap, and the windows of period that a gap brings back.

For lambda above 2/3 and l = 0 there are intervals of mu in which no periodic orbit is stable; with l > 0 there are
stable orbits instead. Run it with `python examples/robust_chaos.py`; it writes robust_chaos.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Draw density and largest exponent for l = 0 and l > 0; return the share of mu with a positive exponent."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=800, help="values of mu")
    parser.add_argument("--out", default="robust_chaos.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    lam = 0.9
    mu = np.linspace(0.02, 0.6, options.values)
    fig, panels = gz.plot.panels(174, 120, rows=2, columns=2, sharex=True)
    shares = {}
    for l, raster, exponents in zip((0.0, 0.5), panels[:2], panels[2:], strict=True):
        G = gz.gap_map(lam=lam, mu=0.1, l=l)
        gz.plot.density(gz.density(G, "mu", mu, bins=300, starts=20, transient=1000), raster)
        found = gz.lyapunov(G, "mu", mu, starts=2, transient=1000)
        gz.plot.lyapunov(found, exponents)
        raster.set_title(f"l = {l:g}")
        shares[l] = float((found.exponent[:, 0, 0] > 1e-3).mean())
        print(f"l = {l:g}: chaotic for {shares[l]:.0%} of the values of mu")
    print(f"written: {gz.plot.save(fig, options.out)}")
    return shares


if __name__ == "__main__":
    main()
