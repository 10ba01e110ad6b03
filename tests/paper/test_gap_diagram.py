"""One panel of the gap map: the graze is marked where the scan reaches below it, not where its axis has room."""

import numpy as np
import pytest

import grazing as gz
from grazing import theory
from grazing.paper.gap_diagram import gap_panel


@pytest.mark.parametrize(("low", "marked"), [(0.0, False), (-0.02, True)])
def test_the_graze_is_marked_where_the_scan_reaches_below_it(low, marked):
    scan = gz.orbit_diagram(gz.gap_map(0.5, 0.1, 0.1), "mu", np.linspace(low, 0.1, 6), starts=2, keep=8)
    windows = {N: (theory.mu_pd(N, 0.5, 0.1), theory.mu_bc(N, 0.5, 0.1)) for N in (2, 3)}
    _figure, (ax,) = gz.plot.panels()
    assert ("graze" in gap_panel(ax, {"diagram": scan, "windows": windows, "lam": 0.5, "l": 0.1})) == marked
