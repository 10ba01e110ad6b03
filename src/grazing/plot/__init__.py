"""Figures, drawn from results: one function for each, none of them computes."""

from grazing.plot.animation import animate
from grazing.plot.basins import basins
from grazing.plot.bifurcation_diagram import bifurcation_diagram
from grazing.plot.branch import branch
from grazing.plot.chart import chart
from grazing.plot.cobweb import cobweb
from grazing.plot.coexistence import coexistence
from grazing.plot.density import density
from grazing.plot.escape import escape
from grazing.plot.graph import graph
from grazing.plot.grazes import grazes
from grazing.plot.history import history
from grazing.plot.ladder import ladder
from grazing.plot.launches import launches
from grazing.plot.locus import locus
from grazing.plot.lyapunov import lyapunov
from grazing.plot.manifold import manifolds
from grazing.plot.map_graph import graph_of, map_graph
from grazing.plot.orbit_diagram import orbit_diagram
from grazing.plot.portrait import portrait
from grazing.plot.provenance import provenance, provenance_of
from grazing.plot.response import response
from grazing.plot.spectrum import spectrum
from grazing.plot.style import figure, panels, period_colour, rendered, save, styled
from grazing.plot.table import table
from grazing.plot.trajectory import trajectory
from grazing.plot.tree import tree
from grazing.plot.validity import validity
from grazing.plot.windows import windows
from grazing.plot.word_statistics import word_statistics
from grazing.plot.zdm import zdm

__all__ = [
    "animate", "basins", "bifurcation_diagram", "branch", "chart", "cobweb", "coexistence", "density", "escape",
    "figure", "graph", "graph_of", "grazes", "history", "ladder", "launches", "locus", "lyapunov", "manifolds",
    "map_graph", "orbit_diagram", "panels", "period_colour", "portrait", "provenance", "provenance_of", "rendered",
    "response", "save", "spectrum", "styled", "table", "trajectory", "tree", "validity", "windows",
    "word_statistics", "zdm",
]  # fmt: skip
