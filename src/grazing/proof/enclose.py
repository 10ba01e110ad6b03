"""Proven enclosures of the parameter values at which a periodic orbit of the oscillator bifurcates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.orbits.bounce_orbit import BounceOrbit
from grazing.orbits.contacts import numbered, pieces_of, sizes_of
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.orbit import Orbit
from grazing.oscillator.sure import Undecided
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name, named_by
from grazing.proof.certify import Certificate, accepted, at_some_precision, balls, guess_of, not_proven, with_impacts
from grazing.proof.clearance import Cleared, check_impacts, cleared_flight, started
from grazing.proof.curve import End, curve_image, enclosed_curve, end_of, units_of
from grazing.proof.equations import Equations
from grazing.proof.gap import GapProof
from grazing.proof.gap_branch import nearest_edge
from grazing.proof.reasons import SADDLE, NotProven, Stage
from grazing.proof.report import bound, clear_rows, described, impact_rows, jury, stability_of
from grazing.proof.search import TOUCH, Dip, Search, dips_of
from grazing.proof.seen import alone
from grazing.proof.table_value import prove_table_value
from grazing.proof.text import about, enclosed, exact_text, short
from grazing_checker.sentence import EVENTS, signature, value_sentence
from grazing_checker.table_value import table_value_sentence

if TYPE_CHECKING:
    from flint import arb

    Point = list[arb]


def enclose(orbit: Orbit, kind: str, name: str) -> Certificate | GapProof:
    """Prove that a periodic orbit bifurcates at a value of a parameter, and enclose that value.

    Parameters
    ----------
    orbit : Orbit
        An orbit near the bifurcation, of the oscillator, over one wall or between walls which may move, of a ball on a
        table, or of the gap map; from it the search goes along its branch. It may be that of the special point of a
        branch. Of one of the oscillator at a graze, an impact without speed is taken for the touch.
    kind : str
        ``"pd"``, ``"lp"``, ``"ns"`` or ``"gr"``: period doubling, fold, Neimark-Sacker, graze of a dip. For the gap map
        ``"pd"``, ``"lp"``, ``"gr"`` or ``"bcb"``, the border collision.
    name : str
        The parameter that varies, for the gap map mu; the others keep their values, taken as exact. One alone: not
        ``r`` for the ``A.r`` and ``B.r`` of two walls or objects.

    Returns
    -------
    Certificate
        ``value`` is the enclosure, at most some 1e-13 of the parameter's size and its unit in the model
        (``model.unit_of``) wide. The proof shows a curve of orbits in a small box, one for every value of one
        coordinate, on which the test function of the bifurcation changes its sign.

    Raises
    ------
    InputError
        For what is no orbit of the oscillator, a table or the gap map, an unknown kind or parameter, or a name that
        stands for several.

    Notes
    -----
    The test functions are 1 + tr + det (pd), 1 - tr + det (lp), det - 1 with complex multipliers (ns), the height of
    the dip (gr); on a table the products of 1 + L, of 1 - L and of 1 - L L' over the multipliers L. The curve is
    parametrised by ``name``, a fold by one of the other coordinates; along it Krawczyk's test holds for all of the box
    at once, so that orbits depend continuously on it and the intermediate value theorem gives the zero. That there is
    one zero only is not claimed.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.enclose import enclose
    >>> orbit = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1]
    >>> certificate = enclose(orbit, "pd", "d")
    >>> certificate
    <Certificate: pd of the periodic orbit with 1 impact in 3 periods, d = 0.123281449643921 to within 1.5e-14>
    """
    if isinstance(orbit, Orbit) and orbit.map.origin.orbits is not None:
        return _gap_edge(orbit, kind, name)
    if isinstance(orbit, BounceOrbit):
        return enclose_bounces(orbit, kind, name)
    orbit = with_impacts(orbit)
    if not isinstance(kind, str) or kind not in EVENTS:
        raise InputError(f"kind is {shown(kind)}; allowed are {', '.join(EVENTS)}")
    model = orbit.model
    name, *others = named_by(checked_name(name, model.params, "the model"), model.params)
    if others:
        several = " and ".join([name, *others])
        raise InputError(f"{name.rpartition('.')[2]} stands for {several}; an enclosure is of one of them")
    model.refuse_base("a proof", [name])
    orbit = without_touches(orbit, name) if kind == "gr" else orbit
    title = f"{kind} of the periodic orbit {signature(orbit.impacts, orbit.period)}"
    try:
        if kind != "gr" and orbit.impacts == 0:
            raise NotProven(
                "the multipliers of an orbit without impacts are those of the free ball; it has a graze only"
            )
        data, inequalities = at_some_precision(lambda bits: _proof(orbit, kind, name, bits))
        of = "bifurcation value" if alone(model) else "bifurcation value with walls"
        document = accepted(of, value_sentence(data), data, inequalities)
    except NotProven as error:
        return not_proven(title, error)
    return Certificate(
        True, document["statement"], "", document, f"{title}, {name} = {about(*data['claims']['value'])}"
    )


def _gap_edge(orbit: Orbit, kind: str, name: str) -> GapProof:
    """Return the proof of the edge nearest to the orbit's own mu that the orbit leads to."""
    kinds = {"pd": "pd", "lp": "lp", "gr": "gr", "bcb": "bc"}
    if not isinstance(kind, str) or kind not in kinds:
        raise InputError(f"kind is {shown(kind)}; allowed for the gap map are {', '.join(kinds)}")
    if not isinstance(name, str) or name != "mu":
        raise InputError(f"name is {shown(name)}; edges of the gap map are enclosed in mu only")
    proof = nearest_edge(orbit, kinds[kind])
    if proof is None:
        return GapProof(False, f"Nothing is proven: no {kind} of {orbit.word} is joined to this orbit in mu.", None)
    return proof


def enclose_bounces(orbit: BounceOrbit, kind: str, name: str) -> Certificate:
    """Return the certificate of a bifurcation of an orbit on a table."""
    of, title = "bifurcation value on a table", f"{kind} of the periodic orbit {orbit.word} on a table"
    try:
        data, inequalities = prove_table_value(orbit, kind, name)
        document = accepted(of, table_value_sentence(data), data, inequalities)
    except NotProven as error:
        return not_proven(title, error)
    return Certificate(
        True, document["statement"], "", document, f"{title}, {name} = {about(*data['claims']['value'])}"
    )


def without_touches(orbit: ImpactOrbit, name: str) -> ImpactOrbit:
    """Return an orbit without those of its impacts that have no speed and get none: there it touches the wall."""
    slow = TOUCH * sizes_of(orbit.model)[1]
    hits = np.maximum(np.abs(orbit.incoming), np.abs(orbit.outgoing)) > slow
    if hits.all():
        return orbit
    p = np.array([orbit.model.params[name]])
    walls = [wall for wall, hit in zip(numbered(orbit.model, orbit.walls), hits, strict=True) if hit]
    if not walls:
        free = FreeEquations(orbit.model, (name,))
        return free.orbit(free.start(p), p)
    pieces = pieces_of(orbit.model, orbit.incoming[hits], walls)
    equations = ImpactEquations(orbit.model, (name,), orbit.period, pieces)
    return equations.orbit(np.concatenate([orbit.times[hits], orbit.outgoing[hits]]), p)


def _proof(orbit: ImpactOrbit, kind: str, name: str, bits: int) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return data and inequalities of a certificate, or raise NotProven or Open."""
    from flint import arb

    model, n, N = orbit.model, orbit.impacts, orbit.period
    equations = Equations(model, n, N, name, orbit.incoming.tolist(), numbered(model, orbit.walls))
    size = equations.size
    with Stage("the orbit near the bifurcation is singular"):
        start = [*guess_of(orbit), arb(model.params[name])]
        search = Search(equations, kind, start)
        centre = search.zero()
    centre, pinned = [short(x, bits // 2) for x in centre], search.pinned
    units = units_of(equations, centre)
    centre[pinned] = (
        short(centre[pinned] + units[pinned], bits // 2) - units[pinned]
    )  # the ends, beside, are then exact
    with Stage("the curve of orbits through the bifurcation is not enclosed"):
        C, radius, rows = enclosed_curve(equations, centre, units, pinned, bits)
        ends = [end_of(equations, centre, radius, C, rows, pinned, sign, bits) for sign in (-1, 1)]
    box = balls(centre, radius)
    with Stage("the reset law or the velocity of an impact is not decided over the box"):
        flights = equations.flights(box)
        check_impacts(flights, n)
    flow = equations.flow(box)
    dip = search.dip
    touches = {dip.flight: dip.wall} if dip else {}
    cleared = [cleared_flight(equations, flights, i, box, touches.get(i)) for i in range(len(flights))]
    trace, det = equations.trace_and_det(flights, flow)
    if kind == "ns" and trace**2 / 4 - det > 0:
        raise NotProven(SADDLE)
    with Stage("the test function of the bifurcation does not surely change its sign"):
        tests, time = sign_rows(equations, kind, ends, cleared, dip)
        if kind == "ns":
            tests.append(bound("trace^2/4 - det", trace**2 / 4 - det, "<", 0))
            if not trace**2 / 4 - det < 0:
                raise Undecided
    described_model = described(equations, bits)
    data = {
        **described_model,
        "type": kind,
        "pinned": pinned,
        "centre": [exact_text(x) for x in centre],
        "radius": [exact_text(x) for x in radius],
        "preconditioner": [[x.hex() for x in row] for row in C],
        "cuts": [[exact_text(one.start), exact_text(one.end)] for one in cleared] if n else [],
        "dip": dip_text(equations, dip, cleared, time),
        "ends": [
            {"centre": [exact_text(x) for x in end.centre], "radius": [exact_text(x) for x in end.radius]}
            for end in ends
        ],
        "claims": {
            "value": enclosed(box[size], 24),
            "box": [enclosed(x) for x in box[:size]],
            "ends": [stability_of(jury(*end.sums), described_model, balls(end.centre, end.radius)) for end in ends],
        },
    }
    image = curve_image(equations, centre, radius, C, rows, pinned)
    inequalities = [
        *(bound(f"curve, coordinate {i + 1}", a, "<", r) for i, (a, r) in enumerate(zip(*image, strict=True))),
        *impact_rows(flights, n),
        *clear_rows(cleared, equations, flights),
        *(
            bound(f"end {i + 1}, coordinate {m + 1}", a, "<", r)
            for i, end in enumerate(ends)
            for m, (a, r) in enumerate(end.test)
        ),
        *tests,
    ]
    return data, inequalities


def sign_rows(
    equations: Equations, kind: str, ends: list[End], cleared: list[Cleared], dip: Dip | None
) -> tuple[list[dict[str, str]], arb | None]:
    """Return the inequalities that show the change of sign, and for a graze the time at which heights are taken."""
    if kind != "gr":
        column = {"pd": "1 + trace + det", "lp": "1 - trace + det", "ns": "1 - det"}[kind]
        values = [jury(*end.sums)[column] for end in ends]
        return [_signed(f"{column} at end {i + 1}", x) for i, x in enumerate(_opposite(values))], None
    assert dip is not None
    found = cleared[dip.flight]
    if found.dip is None or found.bend is None:
        raise NotProven("the orbit has no dip at a wall where one was found by numbers")
    times = [
        min(
            (one for one in dips_of(equations, end.flights, dip.flight, end.centre) if one.wall == dip.wall),
            key=lambda one: float(one.height),
        ).time
        for end in ends
    ]
    time = short((times[0] + times[1]) / 2, 128)
    heights = []
    for end in ends:
        f, x = end.flights[dip.flight], balls(end.centre, end.radius)
        flow = equations.flow(x, wall=dip.wall)
        moment = flow.read(flow.fly(started(equations, f, x, flow, dip.wall), f.t, time))
        least = moment.y - moment.v**2 / (2 * found.bend)
        if not (least > 0 or moment.y < 0):
            raise Undecided
        heights.append(least if least > 0 else moment.y)
    rows = [_signed(f"height of the dip at end {i + 1}", x) for i, x in enumerate(_opposite(heights))]
    return [bound("acceleration in the dip", found.bend, ">", 0), *rows], time


def _opposite(values: list[arb]) -> list[arb]:
    """Return two balls of surely opposite signs, or raise Undecided."""
    one, two = values
    if not ((one > 0 and two < 0) or (one < 0 and two > 0)):
        raise Undecided
    return values


def _signed(name: str, x: arb) -> dict[str, str]:
    return bound(name, x, ">" if x > 0 else "<", 0)


def dip_text(equations: Equations, dip: Dip | None, cleared: list[Cleared], time: arb | None) -> dict[str, Any]:
    """Return the dip that touches, as text; empty if none does."""
    if dip is None or time is None:
        return {}
    one = cleared[dip.flight].dip
    assert one is not None
    wall = {} if alone(equations.model) else {"wall": equations.model.walls[dip.wall].name}
    stretch = {"from": exact_text(one[0]), "to": exact_text(one[1]), "time": exact_text(time)}
    return {"flight": dip.flight + 1, **wall, **stretch}
