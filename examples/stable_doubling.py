"""A period doubling whose doubled orbit is stable, found by branches and confirmed by simulation.

In the paper's oscillator every period doubling of a one-impact orbit is subcritical: beyond it the orbit jumps. In
this one the doubled orbit is stable and takes over. Run it with `python examples/stable_doubling.py`.
"""

import argparse

import numpy as np

import grazing as gz


def main(tokens=None):
    """Draw scan and branches, and return the doubling, the share of starts on the doubled orbit and their distance."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=300, help="values of d in the figure")
    parser.add_argument("--out", default="stable_doubling.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    model = gz.pinball(alpha=1.96, k=0.6, omega=2.1, r=0.6, V=0.1, d=-0.05)
    low, high = -0.08, -0.05
    window = gz.windows(model, "d", N=1).isel(window=0)
    middle = 0.5 * (float(window.low) + float(window.high))
    orbit = next(o for o in gz.one_impact_orbits(model.replace(d=middle), 1) if o.stable and o.admissible)
    bounds = min(low, middle), max(high, middle)
    branch = gz.continuation(orbit.map, orbit, "d", bounds)
    doubling = next(one for one in branch.special if one.type == "pd" and one.admissible)
    doubled = gz.continuation(orbit.map, doubling, "d", bounds)
    stable = [o for o in doubled.pieces[0].orbits[2:] if o.stable and o.admissible]
    print(f"{doubling}; doubled orbits that are stable: {len(stable)}")

    # from random starts, at the middle of the range in which the doubled orbit is stable
    ends = [o.map.params["d"] for o in stable]
    value = 0.5 * (min(ends) + max(ends))
    (known,) = (o for o in doubled.at(value) if o.stable and o.admissible)
    P = known.map
    scan = gz.orbit_diagram(P, "d", [value], starts=40, transient=2000, keep=32)
    on_it = [start for start in range(40) if int(scan.period[0, start]) == known.period]
    last = np.stack([scan.u.values[0, :, -1], scan.v.values[0, :, -1]], axis=-1)[on_it]
    apart = np.abs(last[:, None] - known.points[None]).max(axis=2).min(axis=1)
    print(f"at d = {value:.6f}: {len(on_it)} of 40 starts settle on period {known.period}, within {apart.max():.1e}")

    values = np.linspace(min(ends) - 0.002, doubling.value + 0.003, options.values)
    drawn = gz.plot.bifurcation_diagram(gz.bifurcation_diagram(P, "d", values, starts=10, transient=4000))
    print(f"written: {gz.plot.save(drawn, options.out)}")
    return {"doubling": doubling.value, "share": len(on_it) / 40, "apart": float(apart.max())}


if __name__ == "__main__":
    main()
