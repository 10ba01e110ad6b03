"""Proofs that a periodic orbit of the oscillator exists, is admissible, and is stable or unstable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import inf, nextafter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grazing.copies import ByValue
from grazing.late import named
from grazing.orbits.bounce_orbit import BounceOrbit
from grazing.orbits.contacts import model_of, numbered
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.orbit import Orbit
from grazing.orbits.signature import flown, rests
from grazing.oscillator.sure import Undecided
from grazing.outcome import InputError, shown
from grazing.pool import LOCK
from grazing.proof.clearance import check_impacts, cleared_flight
from grazing.proof.equations import Equations, Matrix
from grazing.proof.expression import NotAnExpression
from grazing.proof.flow import Blurred, TooLong
from grazing.proof.gap import GapProof
from grazing.proof.krawczyk import NoConvergence, contraction, inverse, newton, remainder, residual_of
from grazing.proof.reasons import NotProven, Open, Stage, Virtual
from grazing.proof.repeats import is_own_image, shift_margins
from grazing.proof.report import (
    bound,
    clear_rows,
    described,
    existence_rows,
    impact_rows,
    jury,
    loose,
    multiplier_text,
    stability_of,
    stability_rows,
)
from grazing.proof.seen import Dual, Seen, alone
from grazing.proof.table import prove_bounces
from grazing.proof.text import below, enclosed, exact_text, short, write_certificate
from grazing_checker.check import check, trusted_base
from grazing_checker.envelope import seal
from grazing_checker.reading import Rejected
from grazing_checker.sentence import active_harmonics, orbit_sentence, signature
from grazing_checker.table import table_sentence

if TYPE_CHECKING:
    from flint import arb

#: Bits of the midpoints, tried one after the other.
PRECISIONS = (256, 512, 1024)
#: Half-widths of the box of uniqueness, as powers of two of the natural scales, and the contraction rate asked for.
WIDEST, NARROWEST, RATE = -3, -90, 0.5
TOO_LONG = (
    "a flight has too many time scales to be enclosed step by step; raise omega, lower alpha or k, or prove an orbit "
    "of fewer periods"
)
UNDECIDED = (
    "stability is not decided: a multiplier is on the unit circle or too close to it, as where energy is conserved"
)


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(ByValue):
    """What was proven, or why nothing was.

    Parameters
    ----------
    proven : bool
        Whether there is a proof.
    statement : str
        One sentence: exactly what is proven; without a proof it says so.
    reason : str
        Why there is no proof, or why a part of it is missing, and what to try; empty if nothing is missing.
    document : dict or None
        The certificate, as JSON values; None without a proof.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.certify import certify
    >>> orbit = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1]
    >>> certify(orbit)
    <Certificate: periodic orbit with 1 impact in 3 periods, proven stable>
    """

    proven: bool
    statement: str
    reason: str
    document: dict[str, Any] | None
    title: str

    def save(self, path: str | Path) -> Path:
        """Write the certificate as JSON and return the path.

        Raises
        ------
        InputError
            If nothing is proven.
        """
        if self.document is None:
            raise InputError(f"there is nothing to save: {self.reason}")
        return write_certificate(self.document, path)

    @property
    def claims(self) -> dict[str, Any]:
        """What is claimed, with its bounds as decimals rounded to the safe side; empty without a proof."""
        return {} if self.document is None else dict(self.document["data"]["claims"])

    @property
    def value(self) -> tuple[float, float] | None:
        """The enclosure of a bifurcation value, rounded outwards to doubles; None if there is none."""
        if "value" not in self.claims:
            return None
        low, high = (Fraction(x) for x in self.claims["value"])
        below, above = float(low), float(high)
        return (below if below <= low else nextafter(below, -inf)), (above if above >= high else nextafter(above, inf))

    def __repr__(self) -> str:
        return f"<Certificate: {self.title}>"


def certify(orbit: Orbit) -> Certificate | GapProof:
    """Prove that a periodic orbit exists, is admissible, and is stable or unstable.

    Parameters
    ----------
    orbit : Orbit
        Of the oscillator, over one wall or between walls, which may move: any number of impacts, none included, in any
        number of periods. Its times and velocities are a guess only. An orbit of the gap map is proven by
        :func:`grazing.proof.gap.certify_gap_orbit`. An orbit of a ball on a table is proven in the places of its
        impacts and the times between them.

    Returns
    -------
    Certificate
        ``proven`` says whether existence, local uniqueness and admissibility over the whole orbit are proven; then
        ``statement`` says of its stability what is proven. Otherwise ``reason`` says why not: a virtual
        orbit, a reset law that ball arithmetic cannot evaluate, a decision that 1024 bits leave open.

    Raises
    ------
    InputError
        For anything but an orbit of the oscillator, the gap map or a table.

    Notes
    -----
    Krawczyk's test in ball arithmetic for the times of the impacts and the velocities after them
    (:mod:`grazing.proof.krawczyk`); the whole flights are enclosed to show that they meet no wall anywhere else
    (:mod:`grazing.proof.clearance`); the multipliers follow from flights and saltation matrices. The parameters of the
    model are taken as exact. :func:`check_certificate` verifies the result by other means.

    References
    ----------
    R. Krawczyk, Computing 4 (1969) 187-201; A. Neumaier, Interval Methods for Systems of Equations, Cambridge 1990,
    section 5.2.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.certify import certify
    >>> certificate = certify(gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1])
    >>> certificate.proven, certificate.claims["stability"]
    (True, 'stable')
    """
    found: Certificate | GapProof = (named(orbit.proven_by) if isinstance(orbit, Orbit) else certify_impacts)(orbit)
    return found


def certify_impacts(orbit: object) -> Certificate:
    """Return the certificate of an orbit of an oscillator; raise InputError for any other orbit."""
    orbit = with_impacts(orbit)
    n, N = orbit.impacts, orbit.period
    name = f"periodic orbit {signature(n, N)}"
    kind = "periodic orbit" if alone(orbit.model) else "periodic orbit with walls"
    try:
        data, inequalities = at_some_precision(lambda bits: _proof(orbit, bits))
        document = accepted(kind, orbit_sentence(data), data, inequalities)
    except Virtual as error:
        deep = f"; as computed, it is {orbit.depth:.6g} deep in a wall" if orbit.depth > 0.0 else ""
        return not_proven(name, NotProven(f"{error}{deep}"))
    except NotProven as error:
        return not_proven(name, error)
    stability, statement = data["claims"]["stability"], document["statement"]
    missing = "" if stability != "undecided" else _undecided_stability(data)
    said = "proven, stability undecided" if missing else f"proven {stability}"
    return Certificate(True, statement, missing, document, f"{name}, {said}")


def certify_bounces(orbit: BounceOrbit) -> Certificate:
    """Return the certificate of an orbit on a table."""
    kind, name = "periodic orbit on a table", f"periodic orbit {orbit.word} on a table"
    try:
        data, inequalities = prove_bounces(orbit)
        document = accepted(kind, table_sentence(data), data, inequalities)
    except NotProven as error:
        return not_proven(name, error)
    statement, stability = document["statement"], data["claims"]["stability"]
    missing = "" if stability != "undecided" else UNDECIDED
    said = "proven, stability undecided" if missing else f"proven {stability}"
    return Certificate(True, statement, missing, document, f"{name}, {said}")


def with_impacts(orbit: object) -> ImpactOrbit:
    """Return an orbit of the oscillator with its impacts, or raise InputError."""
    if isinstance(orbit, ImpactOrbit):
        return orbit
    if isinstance(orbit, Orbit) and model_of(orbit.map) is not None:
        if rests(orbit):
            raise InputError(f"{orbit!r} comes to rest on a wall; orbits that rest or chatter are not proven")
        return flown(orbit)
    raise InputError(
        f"orbit is {shown(orbit)}; give a periodic orbit of an oscillator, a table or the gap map, "
        "such as one of gz.one_impact_orbits(model, N)"
    )


def accepted(
    kind: str, statement: str, data: dict[str, Any], inequalities: list[dict[str, Any]]
) -> dict[str, Any]:  # fmt: skip
    """Return a certificate that the checker accepts, or raise NotProven: what it does not follow is not called proven.

    Its bounds on the work are of a whole certificate, those of the finder of one flight.
    """
    document = seal(kind, statement, trusted_base(kind), data, inequalities)
    try:
        with LOCK:
            check(document)
    except Rejected as error:
        raise NotProven(f"the checker does not accept the certificate: {error}") from None
    return document


def not_proven(name: str, error: NotProven) -> Certificate:
    """Return the certificate that says why there is none."""
    return Certificate(False, f"Nothing is proven: {error}.", str(error), None, f"{name}, not proven")


def at_some_precision(prove: Callable[[int], tuple[dict[str, Any], list[dict[str, Any]]]]) -> Any:
    """Return the first proof that a precision allows, or raise NotProven."""
    from flint import ctx

    said = ""
    for bits in PRECISIONS:
        try:
            with LOCK, ctx.workprec(bits):
                return prove(bits)
        except Open as error:
            said = str(error)
        except Blurred:
            said = TOO_LONG
        except TooLong:
            raise NotProven(TOO_LONG) from None
        except NoConvergence:
            raise NotProven("Newton's method does not converge at an end of the curve; give another orbit") from None
        except NotAnExpression as error:
            raise NotProven(
                f"the reset law cannot be written as an expression ({error}); write it with arithmetic, comparisons "
                "and abs of its arguments only"
            ) from None
    raise NotProven(f"{said}, to {PRECISIONS[-1]} bits")


def _undecided_stability(data: dict[str, Any]) -> str:
    t, d = ([Fraction(x) for x in data["claims"][key]] for key in ("trace", "det"))
    if max(map(abs, t)) < 1 + d[0] and d[1] < 1:
        return (
            "stability is not decided: both multipliers are inside the unit circle, but an impact leaves with w = 0, "
            "and the reset law may throw back motions beside it that meet the wall slowly; use a law that makes 0 of 0"
        )
    if not data["impacts"] and float.fromhex(data["model"]["alpha"]) == 0.0:
        return (
            "stability is not decided: without damping and impacts both multipliers are on the unit circle, "
            "and nothing attracts or repels"
        )
    trace, det = (" to ".join(data["claims"][key]) for key in ("trace", "det"))
    return (
        f"stability is not decided: a multiplier is on the unit circle or too close to it (trace {trace}, determinant "
        f"{det}); vary a parameter, or enclose the bifurcation instead"
    )


def guess_of(orbit: ImpactOrbit) -> list[arb]:
    """Return the coordinates of an orbit of floats: times and velocities after, or (u - sigma, v) at t = 0."""
    from flint import arb

    if orbit.impacts:
        return [arb(float(x)) for x in (*orbit.times, *orbit.outgoing)]
    u, v = (Dual(arb(float(x)), arb(0)) for x in orbit.points[0])
    seen = Seen(orbit.model)
    (place, rate), sign = seen.at(0, arb(0)), int(seen.walls[0].sign)
    return [(u - place).times(sign).x, (v - rate).times(sign).x]


def _proof(orbit: ImpactOrbit, bits: int) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return data and inequalities of a certificate, or raise NotProven or Open."""
    n, N = orbit.impacts, orbit.period
    hits = numbered(orbit.model, orbit.walls)
    equations = Equations(orbit.model, n, N, speeds=orbit.incoming.tolist(), hits=hits)
    guess = guess_of(orbit)
    with Stage("the equations of the orbit are singular: two orbits meet, or it is one of a family"):
        try:
            centre = [short(x, bits // 2) for x in newton(equations, guess)]
        except NoConvergence:
            raise NotProven(
                "Newton's method does not converge from the times and velocities given "
                f"(residual {orbit.residual:.1e}); give an orbit of a smaller residual"
            ) from None
        flights = equations.flights(centre)
        natural = equations.scales(centre, flights)
        _same(guess, centre, natural)
        C = inverse(equations.jacobian(flights))
        rows, unique = uniqueness(equations, centre, C, natural)
        radius = existence(residual_of(C, equations, centre, flights), rows, C, unique, bits)
    box = balls(centre, radius)
    with Stage("the reset law or the velocity of an impact is not decided over the box"):
        flights = equations.flights(box)
        check_impacts(flights, n)
    flow = equations.flow(box)
    cleared = [cleared_flight(equations, flights, i, box) for i in range(len(flights))]
    trace, det = equations.trace_and_det(flights, flow)
    margins = jury(trace, det)
    model = described(equations, bits)
    stability = stability_of(margins, model, box)
    apart = shift_margins(equations, box)
    least = all(margin > 0 for margin in apart.values()) if n else active_harmonics(model["model"]) > 0
    image = orbit.symmetric and is_own_image(equations, model, centre, unique, box)
    symmetry = {} if alone(orbit.model) else {"symmetric": image}
    data = {
        **model,
        "centre": [exact_text(x) for x in centre],
        "radius": [exact_text(x) for x in radius],
        "unique": [exact_text(x) for x in unique],
        "preconditioner": [[x.hex() for x in row] for row in C],
        "cuts": [[exact_text(one.start), exact_text(one.end)] for one in cleared] if n else [],
        "claims": {
            "box": [enclosed(x) for x in box],
            "apart": [below(u - r, 3) for u, r in zip(unique, radius, strict=True)],
            "least_period": least,
            "incoming": [loose(f.v) for f in flights] if n else [],
            "trace": loose(trace),
            "det": loose(det),
            "multipliers": multiplier_text(trace, det),
            "stability": stability,
            **symmetry,
        },
    }
    inequalities = [
        *existence_rows(residual_of(C, equations, centre, equations.flights(centre)), rows, C, radius, unique),
        *impact_rows(flights, n),
        *clear_rows(cleared, equations, flights),
        *stability_rows(margins, stability),
        *[bound(f"least period, divisor {q}", margin, ">", 0) for q, margin in apart.items() if least],
    ]
    return data, inequalities


def balls(centre: list[arb], radius: list[arb]) -> list[arb]:
    """Return a box as balls."""
    from flint import arb

    return [c + arb(0, 1) * r for c, r in zip(centre, radius, strict=True)]


def _same(guess: list[arb], centre: list[arb], natural: list[arb]) -> None:
    """Raise NotProven if Newton's method has gone to another orbit: by the scales of each coordinate, and rounding."""
    for a, b, unit in zip(guess, centre, natural, strict=True):
        if float(abs(a - b)) <= 1e-4 * float(unit) + 1e-12 * float(abs(b)):
            continue
        raise NotProven(
            "Newton's method went from the times and velocities given to another orbit; give an orbit of a "
            "smaller residual"
        )


def uniqueness(
    equations: Equations, centre: list[arb], C: list[list[float]], natural: list[arb]
) -> tuple[Matrix, list[arb]]:
    """Return the derivative over the widest box on which the test of uniqueness succeeds, and its half-widths."""
    from flint import arb

    for power in range(WIDEST, NARROWEST, -3):
        unique = [short(arb(2) ** power * x, 24) for x in natural]
        try:
            rows = equations.jacobian(equations.wide_flights(centre, balls(centre, unique)))
        except Undecided:
            continue
        if contraction(C, rows, unique) < RATE:
            return rows, unique
    raise Undecided


def existence(residual: list[arb], rows: Matrix, C: list[list[float]], unique: list[arb], bits: int) -> list[arb]:
    """Return half-widths of a box around the centre that holds the orbit, by Krawczyk's test."""
    from flint import arb

    factor = max([arb(2) ** (-9 * bits // 20), *(4 * a / u for a, u in zip(residual, unique, strict=True))], key=float)
    radius = [short(factor.upper() * u, 24) for u in unique]
    if not all(a + b < r for a, b, r in zip(residual, remainder(C, rows, radius), radius, strict=True)):
        raise Undecided
    if not all(r < u for r, u in zip(radius, unique, strict=True)):
        raise Undecided
    return radius
