"""One run of the report: its size, and everything computed in it, each thing once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from importlib import import_module
from threading import Event, Lock
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

import numpy as np

from grazing.maps.map import Map
from grazing.maps.normal_form import NormalForm, normal_form
from grazing.orbits.windows import windows
from grazing.oscillator.model import Oscillator, pinball
from grazing.outcome import InputError
from grazing.studies.orbit_diagram import orbit_diagram

T = TypeVar("T")


class Size(NamedTuple):
    """How much is computed: parameter values and random starts of a diagram, and cases per proposition."""

    values: int
    starts: int
    cases: int


#: *paper* fills two columns at 300 dots per inch; *small* is for trying out, *large* for a poster.
SIZES = {"small": Size(120, 8, 12), "paper": Size(600, 16, 60), "large": Size(3000, 60, 400)}

#: The set S of the paper: Figures 1.2 to 1.6.
STANDARD = {"alpha": 3.0, "k": 1.0, "omega": 2.2, "t0": 0.0, "r": 0.8}


class Run:
    """The computations of one report; asked for by figures and claims, done at the first request.

    Parameters
    ----------
    size : str
        A key of :data:`SIZES`.
    """

    def __init__(self, size: str = "paper") -> None:
        if size not in SIZES:
            raise InputError(f"size is {size!r}; allowed are {', '.join(SIZES)}: choose one of them")
        self.size = SIZES[size]
        self._done: dict[str, Any] = {}
        self._locks: dict[str, Lock] = {}
        self._lock = Lock()
        self._stopped = Event()

    def stop(self) -> None:
        """Ask diagrams that are being computed in other threads to end at their next value."""
        self._stopped.set()

    def watch(self, done: int, total: int) -> None:
        """Progress of a diagram: raises CancelledError once the run has been asked to stop."""
        if self._stopped.is_set():
            raise CancelledError

    def once(self, name: str, compute: Callable[[], T]) -> T:
        """Return what ``compute`` gives, computed at most once under a name; safe in several threads."""
        with self._lock:
            lock = self._locks.setdefault(name, Lock())
        with lock:
            if name not in self._done:
                self._done[name] = compute()
        result: T = self._done[name]
        return result

    def figure(self, name: str) -> Any:
        """Return the data of a figure, such as ``"1.6"``."""
        return self.once(f"figure {name}", lambda: figure_module(name).compute(self))

    def standard(self, V: float, d: float = 0.12) -> Oscillator:
        """Return the oscillator of the set S."""
        return pinball(**STANDARD, d=d, V=V)

    def normal_form(self, V: float) -> NormalForm:
        """Return the normal form of the set S in d."""
        return self.once(f"normal form {V}", lambda: normal_form(self.standard(V), "d"))

    def window_table(self, V: float) -> Any:
        """Return the exact windows in d of the set S for N = 1 to 11, with typed edges, from d = -0.1 to 0.2."""
        return self.once(f"windows {V}", lambda: windows(self.standard(V), "d", N=range(1, 12), span=(-0.1, 0.2)))

    def windows(self, V: float) -> dict[int, tuple[float, float]]:
        """Return the edges of these windows as a mapping from N."""
        table = self.window_table(V)
        return {
            int(N): (float(low), float(high))
            for N, low, high in zip(table["N"].values, table["low"].values, table["high"].values, strict=True)
        }

    def diagram(
        self,
        P: Map,
        name: str,
        low: float,
        high: float,
        transient: int,
        keep: int,
        values: float = 1.0,
        starts: float = 1.0,
    ) -> Any:
        """Return an orbit diagram on an even grid, as many values and starts as the size of the run says."""
        grid = np.linspace(low, high, max(8, round(values * self.size.values)))
        lanes = max(4, round(starts * self.size.starts))
        return orbit_diagram(
            P, name, grid, starts=lanes, transient=transient, keep=keep, arithmetic="strict", progress=self.watch
        )


def figure_module(name: str) -> ModuleType:
    """Return the module of a figure."""
    return import_module(f"grazing.paper.figure_{name.replace('.', '_')}")
