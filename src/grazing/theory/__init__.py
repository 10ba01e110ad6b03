"""Closed forms of the gap map (2.6), ``x -> lam x + mu`` for x < 0 and ``x -> mu - l - sqrt(x)`` for x >= 0.

Arguments always come in the order (N, lam, mu, l), less those that a formula does not need. The maximal orbit
of period N has the word L^(N-1) R: N - 1 points below zero, then one above. Words other than these, and signs of
lam and l other than 0 < lam < 1 and l >= 0, are solved exactly by the ``word_`` functions.
"""

from grazing.theory.asymptotics import mu_bc_leading, mu_pd_leading, width_ratio
from grazing.theory.changes import WordEdges, WordWindow, word_edges, word_windows
from grazing.theory.cycles import Cycle, CycleExpansion, cycle_expansion
from grazing.theory.doubled import doubled_interval, doubled_multiplier, doubled_orbit
from grazing.theory.edges import geometric_sum, mu_bc, mu_gr, mu_pd
from grazing.theory.interval import Interval
from grazing.theory.maximal import maximal_orbit, multiplier
from grazing.theory.regimes import Regime, lam_exist, lam_overlap, last_window, regime, robust_chaos
from grazing.theory.three_discs import three_disc_cycles
from grazing.theory.thresholds import WorstWindow, l_all, l_coexist, l_exist
from grazing.theory.trapping import trapping_interval
from grazing.theory.windows import (
    Window,
    existence_interval,
    overlapping,
    stability_interval,
    window,
    windows_overlap,
)
from grazing.theory.words import WordOrbit, word_orbits

__all__ = [
    "Cycle",
    "CycleExpansion",
    "Interval",
    "Regime",
    "Window",
    "WordEdges",
    "WordOrbit",
    "WordWindow",
    "WorstWindow",
    "cycle_expansion",
    "doubled_interval",
    "doubled_multiplier",
    "doubled_orbit",
    "existence_interval",
    "geometric_sum",
    "l_all",
    "l_coexist",
    "l_exist",
    "lam_exist",
    "lam_overlap",
    "last_window",
    "maximal_orbit",
    "mu_bc",
    "mu_bc_leading",
    "mu_gr",
    "mu_pd",
    "mu_pd_leading",
    "multiplier",
    "overlapping",
    "regime",
    "robust_chaos",
    "stability_interval",
    "three_disc_cycles",
    "trapping_interval",
    "width_ratio",
    "window",
    "windows_overlap",
    "word_edges",
    "word_orbits",
    "word_windows",
]
