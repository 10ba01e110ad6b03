"""A passive wall against a bumper: orbit diagrams of the oscillator with V = 0 and V = 0.4, one above the other.

Run it with `python examples/passive_and_active.py`; it writes passive_and_active.png.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Compute both diagrams, draw them, and return the share of starts that reach each period at d = 0.12."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=400, help="values of d")
    parser.add_argument("--starts", type=int, default=40, help="random starts per value")
    parser.add_argument("--out", default="passive_and_active.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    fig = gz.plot.figure(width=174, height=150)
    shares = {}
    for V, ax in zip((0.0, 0.4), fig.subplots(2, 1, sharex=True), strict=True):
        model = gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=V)
        P = gz.stroboscopic_map(model)
        graze = gz.normal_form(model, "d").graze
        diagram = gz.orbit_diagram(P, "d", np.linspace(0.05, 0.16, options.values), starts=options.starts)
        gz.plot.orbit_diagram(diagram, ax)
        ax.axvline(graze, lw=0.6, color="black")
        ax.set_title(f"V = {V:g}; the line is the graze, d = {graze:.6f}")

        periods = diagram.period.sel(d=0.12, method="nearest").values
        shares[V] = {int(N): float((periods == N).mean()) for N in np.unique(periods)}
        print(f"V = {V:g}, d = 0.12: " + ", ".join(f"period {N}: {share:.0%}" for N, share in shares[V].items()))
    print(f"written: {gz.plot.save(fig, options.out)}")
    return shares


if __name__ == "__main__":
    main()
