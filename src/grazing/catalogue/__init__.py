"""The catalogue of studies: a file for each, with its record and what is said of its results.

These files import nothing that takes time: ``grazing --help`` reads them all.
"""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from grazing.catalogue.study import Study


@cache
def studies() -> dict[str, Study]:
    """Return the studies by their names, in the order of lists: every module of this package that has a ``STUDY``."""
    modules = [import_module(f"{__name__}.{each.name}") for each in iter_modules(__path__)]
    found = [module.STUDY for module in modules if hasattr(module, "STUDY")]
    return {study.name: study for study in sorted(found, key=lambda study: study.place)}
