"""Imports go down only. Every file of the package is parsed, so an import inside a function counts too."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from grazing.catalogue import studies
from grazing.catalogue.study import Study

SOURCE = Path(__file__).parents[1] / "src"

# Bottom first. A part may import from the layers before its own, and from itself; parts of one layer are
# siblings that do not know each other. `grazing` is the public list, which only the top may use.
LAYERS = (
    ("interrupt", "outcome"),
    ("late", "memory"),
    ("measured", "parameter", "paths", "units"),
    ("writing",),
    ("kernel", "theory"),
    ("copies", "pool"),
    ("systems",),
    ("oscillator",),
    ("billiard",),
    ("maps", "signals"),
    ("orbits",),
    ("proof",),
    ("studies",),
    ("catalogue",),
    ("plans",),
    ("config",),
    ("sweep", "compare"),
    ("plot",),
    ("paper",),
    ("io", "export", "testing"),
    ("grazing", "explorer"),
    ("citation", "prepare"),
    ("cli",),
    ("__main__",),
)
NO_LAYER = "{} has no layer yet: give it one in tests/test_layers.py"
RANK = {part: rank for rank, line in enumerate(LAYERS) for part in line}

# Theory is closed forms in plain Python: of what lies below it may use one part only.
ALLOWED_ONLY = {"theory": {"outcome"}}
# A study knows no other study, except for what they share.
SHARED_BY_STUDIES = {
    "attractors", "boundary", "changes", "classify", "cycles", "differences", "growth", "labels", "outside", "plan",
    "recurrence", "runs", "starts", "trial",
}  # fmt: skip
# Heavy packages, each with the parts that may name it.
OWNERS = {
    "numba": {"kernel"},
    "llvmlite": {"kernel"},
    "matplotlib": {"plot", "paper"},
    "zarr": {"sweep"},
    "dask": {"sweep"},
    "distributed": {"sweep"},
    "pydantic": {"config"},
    "grazing_checker": {"proof", "config"},
}
# The command line parses, calls and saves: no mathematics.
FORBIDDEN = {"cli": {"numpy", "scipy"}}
# What serves every system names none: it asks the origin of a map.
SYSTEMS = ("grazing.oscillator", "grazing.systems", "grazing.billiard")
NAME_NO_SYSTEM = {
    "grazing.maps.bordered", "grazing.maps.columns", "grazing.maps.derivative", "grazing.maps.hits", "grazing.maps.map",
    "grazing.maps.origin", "grazing.maps.own_step", "grazing.maps.pieces", "grazing.maps.pointed",
    "grazing.maps.settle", "grazing.studies", "grazing.catalogue", "grazing.sweep", "grazing.plot", "grazing.cli",
}  # fmt: skip
# In these parts others still serve one system only, such as the closing equations of an oscillator's impacts.
NAME_NO_SYSTEM |= {
    f"grazing.{part}.{name}"
    for part, names in {
        "orbits": "adding_tree branch branch_search branch_table branch_windows corrector curves equations events "
                  "even_equations finder gap_boundaries gap_orbits locus manifold manifold_growth manifold_steps "
                  "map_equations one_sided orbit path periodic piece_end piece_equations piece_letters piece_orbit "
                  "point_equations search_map search_pieces search_steps search_windows special switching word",
        "proof": "check expression gap gap_branch gap_chaos repeats same_model search text",
        "compare": "bifurcation_diagram edges orders search word_branches",
        "config": "build check command files problems settings values",
    }.items()
    for name in names.split()
}  # fmt: skip
# What finds the orbits of one kind of maps is named by their origins, and by nobody here.
FINDERS = {f"grazing.orbits.{name}" for name in ("gap_orbits", "search_bounces", "search_section", "search_steps")}
ASK_FOR_A_FINDER = {"grazing.orbits.finder", "grazing.orbits.periodic"}
# These still do: what they need is not asked of an origin yet.
STILL_NAME_ONE = {"grazing.plot.curves", "grazing.studies.changes", "grazing.studies.runs"}
# How many walls there are, and whether they move, is for the rig to say. Parts that ask it, and import neither class.
SERVE_ALL_WALLS = {
    "grazing.oscillator.walled": {"orbits", "proof", "studies", "catalogue", "compare", "sweep", "plot"},
    "grazing.oscillator.model": {"proof"},
}
# Kernels live here. They call each other by bare name: behind a module's name neither the compiler nor the
# hash of the disk cache can see a function. So these parts import functions from our modules, never a module.
BARE_NAMES = {"kernel", "theory", "systems", "oscillator", "billiard", "maps"}


def module_name(file: Path, source: Path) -> str:
    parts = file.relative_to(source).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")


def imports(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Every import that can run, at whatever depth."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        yield node
    below = node.orelse if is_type_checking(node) else ast.iter_child_nodes(node)
    for child in below:
        yield from imports(child)


def targets(node: ast.Import | ast.ImportFrom, package: str, modules: set[str]) -> Iterator[tuple[str, bool]]:
    """The modules that a statement imports, each with whether a name is bound to the module itself."""
    if isinstance(node, ast.Import):
        yield from ((alias.name, True) for alias in node.names)
        return
    above = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
    base = ".".join([*above, *([node.module] if node.module else [])])
    for alias in node.names:
        full = f"{base}.{alias.name}"
        yield (full, True) if full in modules else (base, False)


def part_of(module: str) -> str:
    """The part of the package that a module belongs to: its first name below `grazing`."""
    names = module.split(".")
    return names[1] if len(names) > 1 else "grazing"


def complaint(importer: str, target: str, binds_module: bool) -> str | None:
    """What is wrong with one import, or None."""
    part, top = part_of(importer), target.split(".")[0]
    if top != "grazing":
        if part not in OWNERS.get(top, {part}):
            return f"only {' and '.join(sorted(OWNERS[top]))} may import {top}"
        return f"{part} may not import {top}" if top in FORBIDDEN.get(part, ()) else None
    if target.startswith(SYSTEMS) and serves_all(importer):
        return f"{importer} serves every system: ask the origin of the map, not {target}"
    if target in FINDERS and importer in ASK_FOR_A_FINDER:
        return f"{importer} asks the origin of a map for its finder, and names none, such as {target}"
    if part in SERVE_ALL_WALLS.get(target, ()):
        return f"{importer} serves any number of walls: ask grazing.oscillator.rig, not {target}"
    other = part_of(target)
    if other not in RANK:
        return NO_LAYER.format(other)
    if binds_module and part in BARE_NAMES:
        return f"import the names that you need, not the module {target}: kernels call kernels by bare name"
    if part == other:
        return study_complaint(importer, target) if part == "studies" else None
    if RANK[other] >= RANK[part]:
        return f"{part} may not import {other}, which is not below it"
    if other not in ALLOWED_ONLY.get(part, {other}):
        return f"{part} may import {' and '.join(sorted(ALLOWED_ONLY[part]))} only"
    return None


def serves_all(importer: str) -> bool:
    """Whether a module must not know which systems there are."""
    above = {importer, ".".join(importer.split(".")[:2])}
    return bool(above & NAME_NO_SYSTEM) and importer not in STILL_NAME_ONE


def study_complaint(importer: str, target: str) -> str | None:
    """What is wrong with an import between studies; their __init__ lists them all and so imports each."""
    one, other = ("".join(name.split(".")[2:3]) for name in (importer, target))
    if not one or one == other or other in SHARED_BY_STUDIES:
        return None
    return f"study {one} may not import {other or 'the list of all studies'}"


#: The constructor of an oscillator makes those between walls, and each wall sees one over it.
CIRCLES = [{"grazing.oscillator.model", "grazing.oscillator.walled"}]


def circles(source: Path) -> list[set[str]]:
    """Modules that import each other, at whatever depth, directly or through others."""
    files = {module_name(file, source): file for file in sorted((source / "grazing").rglob("*.py"))}
    after = {}
    for name, file in files.items():
        package = name if file.name == "__init__.py" else name.rpartition(".")[0]
        nodes = imports(ast.parse(file.read_text(encoding="utf-8")))
        after[name] = {target for node in nodes for target, _binds in targets(node, package, set(files))} - {name}

    def reached(start: str) -> set[str]:
        seen, waiting = set(), [start]
        while waiting:
            for target in after.get(waiting.pop(), set()) - seen:
                seen.add(target)
                waiting.append(target)
        return seen

    far = {name: reached(name) for name in after}
    found = [{other for other in far[name] if name in far.get(other, ())} for name in after if name in far[name]]
    return [one for i, one in enumerate(found) if one not in found[:i]]


AS_A_WHOLE = {"pandas", "pyarrow", "scipy", "xarray"}
HEAVY = "from grazing.late import xarray as xr"
LATE = (
    "it takes a fifth of what a first command waits for, and an interrupt must not cut it short: take it from "
    "grazing.late, where it is called"
)


def violations(source: Path) -> list[str]:
    """Everything wrong below a source folder, as `file:line: what`."""
    files = sorted((source / "grazing").rglob("*.py"))
    modules = {module_name(file, source) for file in files}
    # Folders that have no __init__.py yet are modules too.
    modules |= {".".join(name.split(".")[:i]) for name in modules for i in range(1, name.count(".") + 1)}
    found = []
    for file in files:
        importer = module_name(file, source)
        package = importer if file.name == "__init__.py" else importer.rpartition(".")[0]
        where = file.relative_to(source).as_posix()
        if part_of(importer) not in RANK:
            found.append(f"{where}:1: {NO_LAYER.format(part_of(importer))}")
            continue
        for node in imports(ast.parse(file.read_text(encoding="utf-8"))):
            for target, binds_module in targets(node, package, modules):
                said = complaint(importer, target, binds_module)
                inside = node.col_offset > 0
                here = target.split(".")[0] in AS_A_WHOLE or target == "zarr"  # whose parts come with it
                if (here and importer != "grazing.late") or (ast.unparse(node) == HEAVY and not inside):
                    said = said or LATE
                if said:
                    found.append(f"{where}:{node.lineno}: {said}")
    return found


def test_imports_go_down_only():
    assert violations(SOURCE) == []


def test_no_module_imports_itself_through_others():
    assert circles(SOURCE) == CIRCLES


def test_a_planted_circle_is_found(tmp_path):
    texts = {"io": "def f():\n  from grazing.export import a", "export": "from grazing.pool import b",
             "pool": "import grazing.io", "paths": "from grazing.io import c"}  # fmt: skip
    plant(tmp_path, texts)
    assert circles(tmp_path) == [{"grazing.io", "grazing.export", "grazing.pool"}]


def test_the_checker_of_certificates_knows_nothing_of_the_rest():
    """It may be imported from the layers above, and imports itself, python-flint and the standard library only."""
    found = set()
    for file in (SOURCE / "grazing_checker").rglob("*.py"):
        for node in imports(ast.parse(file.read_text(encoding="utf-8"))):
            found |= {target.split(".")[0] for target, _binds in targets(node, "grazing_checker", set())}
    assert found - set(sys.stdlib_module_names) == {"grazing_checker", "flint"}


#: All parts read the records and name no study, but those that are studies, call their functions as such, list them for
#: Python, or have dimensions of the same names.
USE_STUDIES = {
    "catalogue", "compare", "explorer", "grazing", "maps", "orbits", "paper", "plans", "plot", "prepare", "signals",
    "studies", "testing",
}  # fmt: skip
#: Their commands have commands of their own.
NAME_ONE_STUDY = {("grazing.cli.app", "orbit"), ("grazing.cli.orbits", "orbit")}


def named_studies(file: Path, module: str, known: list[Study], modules: set[str]) -> set[str]:
    """The studies that a module names: by a text that is the name, by the function, or by an import of it."""
    names = {name: one.name for one in known for name in (one.name, one.function)}
    homes = {one.compute.partition(":")[0]: one.name for one in known}
    homes |= {f"grazing.catalogue.{one.name}": one.name for one in known}
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    tree, found = ast.parse(file.read_text(encoding="utf-8")), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(names.get(node.value))
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) in ("plot", "grazing.plot", "plans", "gz"):
            found.add(names.get(node.attr))
    for node in imports(tree):
        found |= {homes.get(target) for target, _binds in targets(node, package, modules)}
    return {name for name in found if name is not None}


def test_what_handles_every_study_names_none():
    files = {module_name(file, SOURCE): file for file in sorted((SOURCE / "grazing").rglob("*.py"))}
    known = list(studies().values())
    found = {
        (module, name)
        for module, file in files.items()
        if part_of(module) not in USE_STUDIES
        for name in named_studies(file, module, known, set(files))
    }
    assert found == NAME_ONE_STUDY


@pytest.mark.parametrize(
    "text",
    ["DRAWN = ('density',)", "if study == 'orbit_diagram': pass", "def f():\n  from grazing.studies.chart import TAKEN",
     "from grazing import plot\nplot.windows(1)", "from grazing.catalogue import lyapunov"],
)  # fmt: skip
def test_a_study_that_is_named_is_found(tmp_path, text):
    file = tmp_path / "planted.py"
    file.write_text(text)
    modules = {"grazing.studies.chart", "grazing.catalogue.lyapunov", "grazing.plot"}
    assert len(named_studies(file, "grazing.cli.planted", list(studies().values()), modules)) == 1


def plant(source, texts):
    for name, text in {"__init__": "", **texts}.items():
        file = source / "grazing" / f"{name}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return violations(source)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("outcome", "from grazing.parameter import P", "outcome may not import parameter"),
        ("outcome", "from grazing import gap_map", "outcome may not import grazing"),
        ("outcome", "import grazing", "outcome may not import grazing"),
        ("theory/gap", "from grazing.parameter import P", "theory may import outcome only"),
        ("theory/gap", "from grazing.kernel.lanes import runner", "theory may not import kernel"),
        ("kernel/loop", "from grazing.theory.gap import mu_pd", "kernel may not import theory"),
        ("oscillator/model", "def f():\n  from ..maps import gap_map", "not the module grazing.maps.gap_map"),
        ("oscillator/model", "def f():\n  from ..maps.base import Map", "oscillator may not import maps"),
        ("maps/zdm", "def f():\n    import numba.types", "only kernel may import numba"),
        ("maps/zdm", "from llvmlite import ir", "only kernel may import llvmlite"),
        ("maps/zdm", "from . import gap_map", "not the module grazing.maps.gap_map"),
        ("maps/zdm", "import grazing.maps.gap_map as g", "not the module grazing.maps.gap_map"),
        ("orbits/branch", "from grazing.studies import chart", "orbits may not import studies"),
        ("studies/chart", "from grazing.studies.basins import basins", "study chart may not import basins"),
        ("studies/chart", "from . import basins", "study chart may not import basins"),
        ("studies/chart", "from . import density", "study chart may not import the list of all"),
        ("studies/classify", "from .basins import basins", "study classify may not import basins"),
        ("studies/chart", "if f():\n    import matplotlib.pyplot", "only paper and plot may import"),
        ("compare/scan", "from grazing.plot import axes", "compare may not import plot"),
        ("plot/chart", "from grazing.paper.claims import CLAIMS", "plot may not import paper"),
        ("paper/figure", "from grazing.cli import main", "paper may not import cli"),
        ("studies/chart", "from grazing_checker import check", "only config and proof may import"),
        ("io", "from grazing.testing import check_map", "io may not import testing"),
        ("cli/main", "import numpy as np", "cli may not import numpy"),
        ("cli/main", "from scipy.optimize import brentq", "cli may not import scipy"),
        ("orbits/curves", "from scipy.optimize import brentq", "take it from grazing.late, where it is called"),
        ("orbits/curves", "def f():\n  import xarray as xr", "an interrupt must not cut it short"),
        ("io", "def f():\n  from xarray.backends import ScipyDataStore", "an interrupt must not cut it short"),
        ("io", "def f():\n  from scipy.io import netcdf_file", "an interrupt must not cut it short"),
        ("export", "def f():\n  from pyarrow import parquet", "an interrupt must not cut it short"),
        ("sweep/template", "def f():\n  import zarr", "an interrupt must not cut it short"),
        ("orbits/curves", "from grazing.late import xarray as xr", "where it is called"),
        ("maps/map", "from grazing.oscillator.model import O", "grazing.maps.map serves every system: ask the origin"),
        ("studies/chart", "def f():\n  from grazing.systems.contract import S", "grazing.studies.chart serves every"),
        ("orbits/resting", "from grazing.oscillator.walled import W", "orbits.resting serves any number of walls: ask"),
        ("proof/seen", "from grazing.oscillator.model import O", "proof.seen serves any number of walls: ask"),
        ("orbits/branch", "from grazing.oscillator.rig import R", "grazing.orbits.branch serves every system: ask"),
        ("orbits/periodic", "from grazing.orbits.search_section import S", "periodic asks the origin of a map for its"),
        ("novelty", "", "novelty has no layer yet"),
    ],
)
def test_a_planted_violation_is_found(tmp_path, name, text, said):
    found = plant(tmp_path, {"maps/gap_map": "", "studies/basins": "", name: text})
    assert len(found) == 1
    assert found[0].startswith(f"grazing/{name}.py:")
    assert said in found[0]


def test_what_is_allowed_is_not_found(tmp_path):
    texts = {
        "outcome": "import math\nfrom typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import grazing.cli",
        "kernel/loop": "import math\nimport numba\nimport numpy as np\nfrom grazing.outcome import OK",
        "theory/gap": "from grazing.outcome import InputError\nfrom .other import f",
        "theory/other": "",
        "maps/zdm": "from grazing.theory.gap import mu_pd\nfrom grazing.maps.base import Map",
        "maps/base": "def f():\n    from grazing.late import xarray as xr",
        "late": "",
        "studies/__init__": "from .chart import chart\nfrom .labels import label",
        "studies/chart": "from grazing.studies.classify import classify\nfrom . import labels",
        "studies/classify": "from .labels import label",
        "studies/labels": "",
        "compare/scan": "from grazing import studies\nfrom grazing.orbits.branch import Branch",
        "orbits/branch": "",
        "plot/chart": "def draw():\n    import matplotlib.pyplot as plt",
        "paper/__init__": "",
        "io": "",
        "cli/__init__": "import grazing\nfrom grazing import io, paper\nfrom .options import parse",
        "cli/options": "",
        "__main__": "from grazing.cli import main",
    }
    assert plant(tmp_path, texts) == []


@pytest.mark.parametrize("module", ["grazing", "grazing.cli"])
def test_importing_is_cheap(module):
    # -P, and the source folder first: neither the folder we stand in nor another grazing is asked.
    code = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); import {module}; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    assert "grazing" in loaded
    assert loaded.isdisjoint({"numba", "llvmlite", "scipy", "xarray", "pandas", "matplotlib"})
