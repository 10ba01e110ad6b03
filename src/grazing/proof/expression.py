"""Reset laws as expressions: a law in Python is called with symbols, and what it does to them is written down.

The trees are those of :mod:`grazing_checker.law`. A comparison cannot be answered for a symbol, so the law is run again
with either answer, and the two results become an ``if``: every path through the law is in its tree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import isfinite, nextafter
from typing import Any

from grazing.parameter import parameter_tuple
from grazing_checker.law import LEVELS, NODES, TAKEN, check_law
from grazing_checker.reading import Rejected

#: Most paths through a law.
PATHS = 64

Decisions = tuple[tuple[list[Any], bool], ...]


class NotAnExpression(Exception):
    """The law uses more than arithmetic, comparisons and ``abs`` on its arguments."""


class _Fork(BaseException):
    """A comparison that has no answer yet; no ``except Exception`` of a law may catch it."""

    def __init__(self, condition: list[Any]) -> None:
        super().__init__()
        self.condition = condition


class Run:
    """One run of a law with the answers that its comparisons get, in this order."""

    def __init__(self, decisions: Decisions) -> None:
        self.decisions, self.asked, self.forked = decisions, 0, False

    def symbol(self, leaf: str) -> Symbol:
        """Return the symbol of an argument."""
        return Symbol(leaf, 1, 1, self)

    def answer(self, condition: list[Any]) -> bool:
        """Return the answer of a comparison, or stop the run where there is none yet."""
        known = [held for one, held in self.decisions[: self.asked] if one == condition]
        if known:
            return known[0]
        if self.asked == len(self.decisions):
            self.forked = True
            raise _Fork(condition)
        one, held = self.decisions[self.asked]
        if one != condition:
            raise NotAnExpression("it does not do the same at every call")
        self.asked += 1
        return held


class Symbol:
    """A number that is not known, and the expression that it is."""

    __slots__ = ("levels", "run", "size", "tree")
    __hash__ = None  # type: ignore[assignment]
    __array_ufunc__ = None  # arrays and scalars of numpy leave arithmetic to this class

    def __init__(self, tree: Any, size: int, levels: int, run: Run) -> None:
        if size > NODES or levels > LEVELS:
            raise NotAnExpression("it is too long when written as one expression")
        self.tree, self.size, self.levels, self.run = tree, size, levels, run

    def _of(self, x: Any) -> Symbol:
        return x if isinstance(x, Symbol) else Symbol(written(x), 1, 1, self.run)

    def _node(self, head: str, *parts: Symbol) -> Symbol:
        size, levels = 1 + sum(one.size for one in parts), 1 + max(one.levels for one in parts)
        return Symbol([head, *(one.tree for one in parts)], size, levels, self.run)

    def _compared(self, how: str, x: Any) -> bool:
        return self.run.answer([how, self.tree, self._of(x).tree])

    def __neg__(self) -> Symbol:
        return self._node("-", self)

    def __pos__(self) -> Symbol:
        return self

    def __abs__(self) -> Symbol:
        return self._node("abs", self)

    def __add__(self, x: Any) -> Symbol:
        return self._node("+", self, self._of(x))

    def __sub__(self, x: Any) -> Symbol:
        return self._node("-", self, self._of(x))

    def __mul__(self, x: Any) -> Symbol:
        return self._node("*", self, self._of(x))

    def __truediv__(self, x: Any) -> Symbol:
        return self._node("/", self, self._of(x))

    def __pow__(self, x: Any) -> Symbol:
        return self._node("^", self, self._of(x))

    def __radd__(self, x: Any) -> Symbol:
        return self._node("+", self._of(x), self)

    def __rsub__(self, x: Any) -> Symbol:
        return self._node("-", self._of(x), self)

    def __rmul__(self, x: Any) -> Symbol:
        return self._node("*", self._of(x), self)

    def __rtruediv__(self, x: Any) -> Symbol:
        return self._node("/", self._of(x), self)

    def __rpow__(self, x: Any) -> Symbol:
        return self._node("^", self._of(x), self)

    def __lt__(self, x: Any) -> bool:
        return self._compared("<", x)

    def __le__(self, x: Any) -> bool:
        return self._compared("<=", x)

    def __gt__(self, x: Any) -> bool:
        return self._compared(">", x)

    def __ge__(self, x: Any) -> bool:
        return self._compared(">=", x)

    def __eq__(self, x: object) -> bool:
        return self._compared("==", x)

    def __bool__(self) -> bool:
        return not self._compared("==", 0.0)


def written(x: Any) -> str:
    """Return a number as a leaf, or raise NotAnExpression."""
    if not isinstance(x, (int, float)):
        raise NotAnExpression(f"it computes with {x!r}, which is no number that it got as an argument")
    try:
        number = float(x)
    except OverflowError:
        number = float("inf")
    if number != x or not isfinite(number):
        raise NotAnExpression(f"it computes with {x!r}, which is no finite double")
    return number.hex()


def expression(
    law: Callable[..., Any], params: Mapping[str, float], names: tuple[str, ...], speeds: Iterable[float] = ()
) -> Any:
    """Return the tree of a reset law.

    Parameters
    ----------
    law : callable
        ``law(v, p)``, plain Python.
    params : mapping of str to float
        The law's own parameters, with values at which the tree is compared with the law.
    names : tuple of str
        All fields that ``p`` has.
    speeds : iterable of float
        Velocities at and about which the tree is compared with the law, beside many others: those of an orbit.

    Raises
    ------
    NotAnExpression
        If it is none: says why.

    Examples
    --------
    >>> from grazing_checker.law import law_text
    >>> def bumper(v, p):
    ...     return -p.r * v + (p.V if v < -0.5 else 0)
    >>> law_text(expression(bumper, {"r": 0.8, "V": 0.4}, ("r", "V")))
    '((-p.r)*v + p.V if v < -0.5 else (-p.r)*v + 0.0)'
    """
    paths = [0]

    def followed(decisions: Decisions) -> Any:
        paths[0] += 1
        if paths[0] > 2 * PATHS:
            raise NotAnExpression(f"it has more than {PATHS} paths")
        run = Run(decisions)
        try:
            after = law(run.symbol("v"), parameter_tuple(names)(*(tuple(run.symbol(name) for name in names) or (0.0,))))
        except _Fork as fork:
            yes, no = (followed((*decisions, (fork.condition, held))) for held in (True, False))
            return ["if", fork.condition, yes, no]
        except NotAnExpression:
            raise
        except Exception as error:  # the law is not ours: whatever it raises, it does not take symbols
            raise NotAnExpression(f"{type(error).__name__}: {error}") from error
        if run.forked or run.asked != len(decisions):
            raise NotAnExpression("it does not do the same at every call")
        return after.tree if isinstance(after, Symbol) else written(after)

    clash = sorted(name for name in params if TAKEN.fullmatch(name))
    if clash:
        raise NotAnExpression(f"its parameter {clash[0]!r} has a name that means something of the model: rename it")
    tree = followed(())
    foreign = leaves(tree) & set(names) - set(params)
    if foreign:
        raise NotAnExpression(f"it uses {min(foreign)!r} of the model: give the law a parameter of its own")
    try:
        check_law({"parameters": dict(params), "after": tree})
    except Rejected as error:
        raise NotAnExpression(str(error)) from None
    _compare(law, tree, params, names, speeds)
    return tree


def leaves(tree: Any) -> set[str]:
    """Return the leaves of a tree that are names."""
    if isinstance(tree, str):
        return set() if tree.startswith(("0x", "-0x")) else {tree}
    return set().union(*(leaves(one) for one in tree[1:]), *(leaves(one) for one in tree[1][1:] if tree[0] == "if"))


def in_doubles(tree: Any, at: Mapping[str, float]) -> Any:
    """Return the value of a tree in doubles, operation by operation as the law does it."""
    if isinstance(tree, str):
        return at[tree] if tree in at else float.fromhex(tree)
    head = tree[0]
    if head == "if":
        (how, one, two), yes, no = tree[1:]
        a, b = in_doubles(one, at), in_doubles(two, at)
        held = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b}[how]
        return in_doubles(yes if held else no, at)
    a = in_doubles(tree[1], at)
    if len(tree) == 2:
        return abs(a) if head == "abs" else -a
    b = in_doubles(tree[2], at)
    if head == "^":
        return a**b
    return a + b if head == "+" else a - b if head == "-" else a * b if head == "*" else a / b


def _compare(
    law: Callable[..., Any], tree: Any, params: Mapping[str, float], names: tuple[str, ...], speeds: Iterable[float]
) -> None:
    """Raise NotAnExpression unless law and tree give the same doubles at many speeds, those of the parameters too.

    A law that asks for the type of v hides a branch from symbols: about the speeds of an orbit it is found out.
    """
    sizes = [1.2345678901234567 * 10.0 ** (k / 4) for k in range(-36, 25)]
    sizes += [s for x in params.values() for s in (abs(x), nextafter(abs(x), 0.0), nextafter(abs(x), 1e300))]
    near = [0.0, *(sign * 2.0**-k for k in range(8, 53, 4) for sign in (-1.0, 1.0))]
    sizes += [abs(v) * (1.0 + late) for v in speeds for late in near]
    changed = [dict(params), *({**params, name: x * 1.0009765625} for name, x in params.items())]
    for at in changed:
        p = parameter_tuple(names)(*(tuple(at.get(name, 0.5) for name in names) or (0.0,)))
        for v in (-size for size in sizes if size > 0.0):
            one, two = (_outcome(call) for call in (lambda: law(v, p), lambda: in_doubles(tree, {**at, "v": v})))  # noqa: B023
            if one != two:
                raise NotAnExpression(
                    f"called with numbers it does something else: at v = {v!r} it gives {one}, as an expression {two}"
                )


def _outcome(call: Callable[[], Any]) -> str:
    """Return a result as text, so that NaN and -0.0 can be compared, or the error that it is."""
    try:
        return repr(float(call()))
    except Exception as error:  # the law is not ours
        return type(error).__name__
