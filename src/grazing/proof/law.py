"""The reset law of a model in balls, with its exact slopes: the checker's evaluation of its expression."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from grazing.oscillator.sure import Undecided
from grazing_checker.law import Jet, evaluate, law_values
from grazing_checker.reading import Rejected

if TYPE_CHECKING:
    from flint import arb


def law_of(params: Mapping[str, str | None], tree: Any) -> dict[str, Any]:
    """Return what a certificate says of a law: its parameters in the order of the formula, and the tree of this."""
    law = {"parameters": params, "after": tree}
    return {**law, "parameters": law_values(law)}


class Law:
    """A reset law with its parameters as balls; one of them may be the unknown.

    Parameters
    ----------
    tree : list or str
        The law, as :func:`grazing.proof.expression.expression` returns it.
    params : mapping of str to arb
        The law's parameters, and any others.
    name : str, optional
        The parameter by which derivatives are asked for.
    """

    def __init__(self, tree: Any, params: dict[str, arb], name: str | None = None) -> None:
        from flint import arb

        self.tree = tree
        self.leaves = {key: Jet(x, arb(0), arb(1 if key == name else 0)) for key, x in params.items()}

    def __call__(self, v: arb) -> tuple[arb, arb, arb]:
        """Return the velocity after an impact at v, its slope, and its derivative by the parameter.

        Raises
        ------
        Undecided
            If a comparison in the law holds for a part of the ball only, or the result is not finite.
        """
        from flint import arb

        try:
            after = evaluate(self.tree, {**self.leaves, "v": Jet(v, arb(1), arb(0))})
        except Rejected:
            raise Undecided from None
        if not all(x.is_finite() for x in after):
            raise Undecided
        return after.x, after.by_v, after.by_p
