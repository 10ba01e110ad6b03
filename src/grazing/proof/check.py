"""Check a certificate with ``grazing_checker``, a package of its own that uses nothing of this one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grazing.outcome import InputError
from grazing.pool import LOCK  # the precision that the finder works with is the process's too
from grazing.proof.expression import NotAnExpression, expression
from grazing.proof.same_model import same_model, speeds_in
from grazing_checker import Rejected, check
from grazing_checker.envelope import opened
from grazing_checker.law import law_text


def check_certificate(
    certificate: str | Path | Mapping[str, Any], *, law: Callable[..., Any] | None = None, model: Any = None
) -> str:
    """Verify a certificate anew and return the sentence that it proves.

    Parameters
    ----------
    certificate : path or dict
        A file that ``save`` wrote, or its document.
    law : callable, optional
        A reset law ``law(v, p)`` to hold against the one in the certificate, which is an expression; against that of
        each wall, or object of a table.
    model : Oscillator or Table or Map, optional
        A model to hold against the one in the certificate: walls, objects, laws and the values of all parameters but
        one that is enclosed. Of the gap map the map.

    Returns
    -------
    str
        The statement: it holds if the trusted base does.

    Raises
    ------
    InputError
        If it is no certificate, was changed, or does not prove its statement, or is about another law or model: says
        what is wrong first.

    Notes
    -----
    This calls :func:`grazing_checker.check`, which uses none of the code that found the proof: its flights are Taylor
    series with a bound on what is cut off, where the finder uses matrix exponentials; multipliers come from the map of
    (time, velocity) from impact to impact, where the finder multiplies saltation matrices. Every inequality is
    evaluated anew, every claim compared, and the statement derived anew from the data. So even a certificate that was
    changed and sealed again is rejected if what it then says does not hold. ``python -m grazing_checker FILE`` does the
    same from a copy of the package's folder, with python-flint and nothing else.

    Examples
    --------
    >>> import grazing as gz
    >>> proof = gz.certify(gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1])
    >>> gz.check_certificate(proof.document) == proof.statement
    True
    """
    try:
        with LOCK:
            document = opened(certificate)  # read once: what is compared is what was checked
            said = check(document)
        if law is not None:
            _compare(document["data"], law)
        if model is not None:
            same_model(document["data"], model)
    except Rejected as error:
        raise InputError(f"the certificate is rejected: {error}") from None
    return said


def _compare(data: Mapping[str, Any], law: Callable[..., Any]) -> None:
    """Raise InputError unless a law in Python is the one of a certificate, at every wall or object that it has."""
    known = {f" at wall {one['name']}": one["law"] for one in data.get("walls", ())}
    known |= {f" of {one['name']}": one["law"] for one in data.get("objects", ()) if "law" in one}
    known |= {"": data["law"]} if "law" in data else {}
    if not known:
        raise InputError("this certificate is about a map without a reset law; leave law away")
    for where, one in known.items():
        params = {name: 0.5 if x is None else float.fromhex(x) for name, x in one["parameters"].items()}
        try:
            tree = expression(law, params, tuple(params), speeds_in(data))
        except NotAnExpression as error:
            raise InputError(
                f"law = {law!r} is no expression to hold against the certificate's{where}: {error}"
            ) from None
        if tree != one["after"]:
            raise InputError(
                f"the certificate is right, but about another law{where}: v+ = {law_text(one['after'])}; "
                f"the one given is v+ = {law_text(tree)}"
            )


def opened_certificate(certificate: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    """Return a certificate that was not changed since it was sealed, or raise InputError; it is not checked."""
    try:
        return opened(certificate)
    except Rejected as error:
        raise InputError(str(error)) from None
