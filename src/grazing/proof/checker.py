"""Check any certificate of the package, by other means than those that made it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grazing.oscillator.exact import LOCK  # working precision belongs to the process: one proof at a time
from grazing.outcome import InputError
from grazing.proof.checker_reading import Rejected, demand
from grazing.proof.envelope import read_envelope
from grazing.proof.gap_checker import TRUSTED as GAP_KINDS
from grazing.proof.gap_checker import Rejected as GapRejected
from grazing.proof.gap_checker import check_gap_certificate
from grazing.proof.orbit_checker import check_orbit
from grazing.proof.sentence import TRUSTED_BASE
from grazing.proof.value_checker import check_value

#: What checks which kind of certificate about the oscillator.
CHECKERS: dict[str, Callable[[Mapping[str, Any], Any, Any], str]] = {
    "periodic orbit": check_orbit,
    "bifurcation value": check_value,
}


def check_certificate(certificate: str | Path | Mapping[str, Any], *, law: Callable[..., Any] | None = None) -> str:
    """Verify a certificate anew and return the sentence that it proves.

    Parameters
    ----------
    certificate : path or dict
        A file that ``save`` wrote, or its document.
    law : callable, optional
        The reset law, for a certificate about a law of your own: the file holds its fingerprint only.

    Returns
    -------
    str
        The statement: it holds if the trusted base does.

    Raises
    ------
    InputError
        If it is no certificate, was changed, or does not prove its statement: says what is wrong first.

    Notes
    -----
    The code that found the proof is not used. Flights are Taylor series with a bound on what is cut off, where the
    finder uses matrix exponentials; multipliers come from the map of (time, velocity) from impact to impact, where
    the finder multiplies saltation matrices. Every inequality is evaluated anew, every claim compared, and the
    statement made anew from the data. So even a certificate that was changed and sealed again is rejected if what it
    then says does not hold.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.certify import certify
    >>> proof = certify(gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1])
    >>> check_certificate(proof.document) == proof.statement
    True
    """
    document = read_envelope(certificate)
    kind = document["kind"]
    try:
        if kind in GAP_KINDS:
            with LOCK:
                return check_gap_certificate(document)
        demand(kind in CHECKERS, f"its kind is {kind!r}; allowed are {', '.join((*CHECKERS, *GAP_KINDS))}")
        with LOCK:
            said = CHECKERS[kind](document["data"], document["inequalities"], law)
        demand(document["trusted_base"] == list(TRUSTED_BASE), "the trusted base is not that of this checker")
        demand(document["statement"] == said, f"the statement does not follow from the data; what follows is: {said}")
    except (Rejected, GapRejected) as error:
        raise InputError(f"the certificate is rejected: {error}") from None
    except (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError, ZeroDivisionError) as error:
        raise InputError(f"the certificate is rejected: its data cannot be used ({error})") from None
    return said
