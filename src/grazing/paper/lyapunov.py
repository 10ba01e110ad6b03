"""The Lyapunov exponent of the gap map, from its slopes along an orbit."""

from __future__ import annotations

import numpy as np

from grazing.maps.map import Map


def exponent(P: Map, n: int = 20_000) -> float:
    """Return the Lyapunov exponent of the gap map along an orbit from -0.1."""
    x = P.iterate((-0.1,), 1000 + n)[1000:-1, 0]
    lam = P.params["lam"]
    return float(np.mean(np.log(np.where(x < 0.0, lam, 0.5 / np.sqrt(np.maximum(x, 1e-300))))))
