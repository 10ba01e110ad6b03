"""The reduced maps of a validity map: their parameters cell by cell, and starts that are those of the flow."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.discontinuity import discontinuity_map
from grazing.maps.gap import gap_map
from grazing.maps.linearised import linearised_map
from grazing.maps.map import Map
from grazing.maps.normal_form import NormalForm, constants, normal_form
from grazing.oscillator.constants import steady_response
from grazing.oscillator.flight import modes
from grazing.oscillator.model import Oscillator
from grazing.outcome import OutsideForm
from grazing.studies.runs import Runs

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]


class Place(NamedTuple):
    """A cell: phase at which the flow is seen, parameters of the reduced map (None outside its form), its starts.

    A start w of the flow, y over the wall, is at E (w - before) + after when it reaches the phase of the graze.
    """

    strobe: float
    row: list[float] | None
    E: Floats
    before: Floats
    after: Floats
    form: NormalForm | None
    rung: str
    wall: float = 0.0

    def start(self, states: Floats) -> Floats:
        """Return the starts (dim, n) of the reduced map for those of the flow, (2, n)."""
        form = self.form
        assert form is not None
        wall = np.array([[self.wall], [0.0]])
        w: Floats = self.E @ (states - wall - self.before[:, None]) + self.after[:, None]
        if self.rung not in ("gap", "linearised"):
            return np.asarray(w + wall, np.float64)
        q: Floats = form.to_xy((w + np.array([[form.model.sigma], [0.0]])).T).T / form.scale
        return q[:1] if self.rung == "gap" else q


class Reductions:
    """The reduced maps of all cells: one map, its parameters cell by cell, from the normal form of each."""

    def __init__(self, model: Oscillator, runs: Runs, rung: str) -> None:
        self.model, self.runs, self.rung = model, runs, rung
        first, second = runs.axes
        still = {"t0", *model.reset.params}  # on these the graze does not depend
        if first in still and second in still:
            raise OutsideForm(
                f"the graze depends on neither {first} nor {second}; vary a parameter of the flight, such as d or omega"
            )
        self.name, self.other = (first, second) if first not in still else (second, first)
        self.forms: dict[float, tuple[NormalForm | None, str]] = {}
        self.map: Map
        if rung == "gap":
            self.map = gap_map(0.5, 0.0, 0.0)
        elif rung == "linearised":
            self.map = linearised_map(0.5, 0.1, 0.0, 0.0)
        else:
            self.map = discontinuity_map(model, order=rung)

    def form(self, value: float) -> tuple[NormalForm | None, str]:
        """Return the normal form at a value of the other parameter, if any, and why the reduction is outside it."""
        if value not in self.forms:
            try:
                form = normal_form(self.model.replace(**{self.other: value}), self.name)
                outside = ""
                if self.rung == "gap" and form.b <= 0.0:
                    outside = f"b = {form.b:g} <= 0: the root enters with the other sign, outside (2.6)"
                self.forms[value] = form, outside
            except OutsideForm as error:
                self.forms[value] = None, str(error)
        return self.forms[value]

    def place(self, cell: int) -> Place:
        """Return what the reduced map needs in a cell."""
        at = dict(zip(self.runs.axes, self.runs.values(np.array([cell]))[0].tolist(), strict=True))
        (form, outside), none = self.form(at[self.other]), np.zeros(2)
        if form is None:
            return Place(0.0, None, np.eye(2), none, none, None, self.rung)
        here = self.model.replace(**at)
        c = constants(here)
        strobe = (form.time + 0.5 * c.T) % c.T
        half = (form.time - strobe) % c.T
        E = np.array(modes(half, c)).reshape(2, 2)
        before, after = (np.array(steady_response(t, c)) for t in (strobe, form.time))
        row: list[float] | None
        if outside:
            row = None
        elif self.rung == "gap":
            row = [form.lam, form.mu(at[self.name]), form.l]
        elif self.rung == "linearised":
            row = [form.lam, form.det, form.mu(at[self.name]), form.l, 1.0 if form.b > 0.0 else -1.0]
        else:
            row = [*here.params.values(), form.time]
        return Place(strobe, row, E, before, after, form, self.rung, here.sigma)

    def finish(self, result: xr.Dataset) -> xr.Dataset:
        """Return the result with the graze, as a function of the other parameter, and why there is no form."""
        forms = [self.form(value) for value in result[self.other].values.tolist()]
        graze = [np.nan if form is None else form.graze for form, _outside in forms]
        about = {"long_name": f"{self.name} at the graze of the steady response", "units": "1"}
        said = sorted({outside for _form, outside in forms if outside})
        result.attrs |= {"rung": self.rung, "unfolds": self.name, "outside": json.dumps(said)}
        return result.assign(graze=(self.other, np.array(graze), about))
