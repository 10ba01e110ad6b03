"""grazing: the dynamics of oscillators that hit things.

Models are forced oscillators with an impact law; seen at a section they are maps; every study takes a map.
Importing this package imports none of numba, scipy, xarray or matplotlib: each name below is loaded when used.
"""

import os
import sys

if (
    sys.argv[:1] == ["-m"]
    and "mgrazing." in f"m{sys.orig_argv[-len(sys.argv)]}."  # what is run: grazing, -mgrazing or a module of it
    and not sys.flags.safe_path
    and sys.path[0] != os.path.dirname(os.path.dirname(__file__))
):
    del sys.path[0]  # the folder that it runs in: modules would be looked for among its files, and be run

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.2.0"

# name -> module that defines it; empty for a module itself
_PUBLIC = {
    "GrazingError": "outcome",
    "InputError": "outcome",
    "Outcome": "outcome",
    "OutsideForm": "outcome",
    "PieceOrbit": "orbits.piece_orbit",
    "Trust": "outcome",
    "UserCodeError": "outcome",
    "describe": "outcome",
    "Forcing": "oscillator.forcing",
    "Oscillator": "oscillator.model",
    "pinball": "oscillator.model",
    "active": "oscillator.reset",
    "newton": "oscillator.reset",
    "reset": "oscillator.reset",
    "triggered": "oscillator.reset",
    "wall": "oscillator.wall",
    "arc": "billiard.objects",
    "disc": "billiard.objects",
    "drain": "billiard.objects",
    "flipper": "billiard.objects",
    "segment": "billiard.objects",
    "flips": "billiard.players",
    "presses": "billiard.players",
    "plunger": "billiard.plunger",
    "strategy": "billiard.strategy",
    "read_table": "config.tables",
    "table": "billiard.table",
    "Surface": "systems.contract",
    "System": "systems.contract",
    "trajectory": "oscillator.trajectory",
    "Map": "maps.map",
    "gap_map": "maps.gap",
    "stroboscopic_map": "maps.stroboscopic",
    "impact_map": "maps.impact",
    "discontinuity_map": "maps.discontinuity",
    "collision_map": "maps.collisions",
    "launch_map": "maps.launches",
    "launches": "maps.launches",
    "grazes": "maps.grazes",
    "zdm": "maps.discontinuity",
    "zdm_points": "maps.discontinuity",
    "NormalForm": "maps.normal_form",
    "normal_form": "maps.normal_form",
    "BounceOrbit": "orbits.bounce_orbit",
    "ImpactOrbit": "orbits.impact_orbit",
    "Orbit": "orbits.orbit",
    "Orbits": "orbits.periodic",
    "Searched": "orbits.periodic",
    "periodic_orbits": "orbits.periodic",
    "Branch": "orbits.branch",
    "boundaries": "orbits.boundaries",
    "continuation": "orbits.branch",
    "ladder": "compare.ladder",
    "Certificate": "proof.certify",
    "certify": "proof.certify",
    "check_certificate": "proof.check",
    "enclose": "proof.enclose",
    "linearised_map": "maps.linearised",
    "Locus": "orbits.locus",
    "adding_tree": "orbits.adding_tree",
    "manifolds": "orbits.manifold",
    "sensitivity": "orbits.sensitivity",
    "response": "compare.response",
    "validity": "compare.validity",
    "words": "orbits.word",
    "word_statistics": "studies.word_statistics",
    "locus": "orbits.locus",
    "grazing_curve": "orbits.grazing_curve",
    "one_impact_orbits": "orbits.one_impact",
    "windows": "orbits.windows",
    "bifurcation_diagram": "compare.bifurcation_diagram",
    "Attractor": "studies.attractors",
    "attractors": "studies.attractors",
    "escape_rate": "studies.escape",
    "basins": "studies.basins",
    "chart": "studies.chart",
    "coexistence": "studies.coexistence",
    "density": "studies.density",
    "graph": "studies.graph",
    "lyapunov": "studies.lyapunov",
    "orbit_diagram": "studies.orbit_diagram",
    "portrait": "studies.portrait",
    "zero_one": "studies.zero_one",
    "sample": "signals.sample",
    "spectrum": "signals.spectrum",
    "to_wav": "signals.sound",
    "load": "io",
    "to_csv": "export",
    "to_dataframe": "export",
    "to_parquet": "export",
    "in_units": "units",
    "save": "io",
    "cite": "citation",
    "config": "",
    "plans": "",
    "plot": "",
    "sweep": "",
    "testing": "",
    "theory": "",
}

__all__ = sorted([*_PUBLIC, "__version__"])

if TYPE_CHECKING:
    from grazing import config as config
    from grazing import plans as plans
    from grazing import plot as plot
    from grazing import sweep as sweep
    from grazing import testing as testing
    from grazing import theory as theory
    from grazing.billiard.objects import arc as arc
    from grazing.billiard.objects import disc as disc
    from grazing.billiard.objects import drain as drain
    from grazing.billiard.objects import flipper as flipper
    from grazing.billiard.objects import segment as segment
    from grazing.billiard.players import flips as flips
    from grazing.billiard.players import presses as presses
    from grazing.billiard.plunger import plunger as plunger
    from grazing.billiard.strategy import strategy as strategy
    from grazing.billiard.table import table as table
    from grazing.citation import cite as cite
    from grazing.compare.bifurcation_diagram import bifurcation_diagram as bifurcation_diagram
    from grazing.compare.ladder import ladder as ladder
    from grazing.compare.response import response as response
    from grazing.compare.validity import validity as validity
    from grazing.config.tables import read_table as read_table
    from grazing.export import to_csv as to_csv
    from grazing.export import to_dataframe as to_dataframe
    from grazing.export import to_parquet as to_parquet
    from grazing.io import load as load
    from grazing.io import save as save
    from grazing.maps.collisions import collision_map as collision_map
    from grazing.maps.discontinuity import discontinuity_map as discontinuity_map
    from grazing.maps.discontinuity import zdm as zdm
    from grazing.maps.discontinuity import zdm_points as zdm_points
    from grazing.maps.gap import gap_map as gap_map
    from grazing.maps.grazes import grazes as grazes
    from grazing.maps.impact import impact_map as impact_map
    from grazing.maps.launches import launch_map as launch_map
    from grazing.maps.launches import launches as launches
    from grazing.maps.linearised import linearised_map as linearised_map
    from grazing.maps.map import Map as Map
    from grazing.maps.normal_form import NormalForm as NormalForm
    from grazing.maps.normal_form import normal_form as normal_form
    from grazing.maps.stroboscopic import stroboscopic_map as stroboscopic_map
    from grazing.orbits.adding_tree import adding_tree as adding_tree
    from grazing.orbits.bounce_orbit import BounceOrbit as BounceOrbit
    from grazing.orbits.boundaries import boundaries as boundaries
    from grazing.orbits.branch import Branch as Branch
    from grazing.orbits.branch import continuation as continuation
    from grazing.orbits.grazing_curve import grazing_curve as grazing_curve
    from grazing.orbits.impact_orbit import ImpactOrbit as ImpactOrbit
    from grazing.orbits.locus import Locus as Locus
    from grazing.orbits.locus import locus as locus
    from grazing.orbits.manifold import manifolds as manifolds
    from grazing.orbits.one_impact import one_impact_orbits as one_impact_orbits
    from grazing.orbits.orbit import Orbit as Orbit
    from grazing.orbits.periodic import Orbits as Orbits
    from grazing.orbits.periodic import Searched as Searched
    from grazing.orbits.periodic import periodic_orbits as periodic_orbits
    from grazing.orbits.piece_orbit import PieceOrbit as PieceOrbit
    from grazing.orbits.sensitivity import sensitivity as sensitivity
    from grazing.orbits.windows import windows as windows
    from grazing.orbits.word import words as words
    from grazing.oscillator.forcing import Forcing as Forcing
    from grazing.oscillator.model import Oscillator as Oscillator
    from grazing.oscillator.model import pinball as pinball
    from grazing.oscillator.reset import active as active
    from grazing.oscillator.reset import newton as newton
    from grazing.oscillator.reset import reset as reset
    from grazing.oscillator.reset import triggered as triggered
    from grazing.oscillator.trajectory import trajectory as trajectory
    from grazing.oscillator.wall import wall as wall
    from grazing.outcome import GrazingError as GrazingError
    from grazing.outcome import InputError as InputError
    from grazing.outcome import Outcome as Outcome
    from grazing.outcome import OutsideForm as OutsideForm
    from grazing.outcome import Trust as Trust
    from grazing.outcome import UserCodeError as UserCodeError
    from grazing.outcome import describe as describe
    from grazing.proof.certify import Certificate as Certificate
    from grazing.proof.certify import certify as certify
    from grazing.proof.check import check_certificate as check_certificate
    from grazing.proof.enclose import enclose as enclose
    from grazing.signals.sample import sample as sample
    from grazing.signals.sound import to_wav as to_wav
    from grazing.signals.spectrum import spectrum as spectrum
    from grazing.studies.attractors import Attractor as Attractor
    from grazing.studies.attractors import attractors as attractors
    from grazing.studies.basins import basins as basins
    from grazing.studies.chart import chart as chart
    from grazing.studies.coexistence import coexistence as coexistence
    from grazing.studies.density import density as density
    from grazing.studies.escape import escape_rate as escape_rate
    from grazing.studies.graph import graph as graph
    from grazing.studies.lyapunov import lyapunov as lyapunov
    from grazing.studies.orbit_diagram import orbit_diagram as orbit_diagram
    from grazing.studies.portrait import portrait as portrait
    from grazing.studies.word_statistics import word_statistics as word_statistics
    from grazing.studies.zero_one import zero_one as zero_one
    from grazing.systems.contract import Surface as Surface
    from grazing.systems.contract import System as System
    from grazing.units import in_units as in_units


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'grazing' has no attribute {name!r}")
    from grazing.interrupt import held_back

    with held_back():  # an interrupt would leave what is imported with it broken
        module = import_module(f"grazing.{_PUBLIC[name] or name}")
    value = getattr(module, name) if _PUBLIC[name] else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
