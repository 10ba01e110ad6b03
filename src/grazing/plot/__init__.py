"""Figures, drawn from results: one function for each, none of them computes."""

from grazing.plot.cobweb import cobweb
from grazing.plot.map_graph import graph_of, map_graph
from grazing.plot.orbit_diagram import orbit_diagram
from grazing.plot.style import figure, panels, period_colour, rendered, save, styled
from grazing.plot.trajectory import trajectory
from grazing.plot.windows import windows
from grazing.plot.zdm import zdm

__all__ = [
    "cobweb",
    "figure",
    "graph_of",
    "map_graph",
    "orbit_diagram",
    "panels",
    "period_colour",
    "rendered",
    "save",
    "styled",
    "trajectory",
    "windows",
    "zdm",
]
