"""Reset laws: expressions that the checker evaluates, with their derivatives, and writes down itself.

A law is a tree of JSON. Its leaves are texts: ``"v"``, the velocity before the impact; the name of a parameter of the
law; or a double as of ``float.hex``. Its nodes are lists: ``["+", a, b]``, likewise ``- * /``; ``["-", a]``;
``["abs", a]``; ``["^", a, b]``, where a^0 is 1; ``["if", [c, a, b], x, y]`` with c one of ``< <= > >= ==``. The
parameters of a law are a name space of their own: nothing here can see those of the model, and the text of a law calls
them ``p.name``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, double, number
from grazing_checker.reading import Rejected, demand, keys, quoted, text_of_double

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
#: Names that mean something of the model, or of its law.
TAKEN = re.compile(r"alpha|k|omega|t0|offset|d|sigma|v|(cos|sin)[0-9]+")
#: Most nodes and levels of a tree, most parameters, and the largest whole exponent.
NODES, LEVELS, PARAMETERS, EXPONENT = 2000, 200, 50, 100
COMPARISONS = ("<", "<=", ">", ">=", "==")


def check_law(law: Any) -> int:
    """Demand that a law is one: parameters, and a tree of which every leaf is known; return how many nodes it has."""
    keys(law, ("parameters", "after"), "the law")
    names = law["parameters"]
    demand(isinstance(names, Mapping) and len(names) <= PARAMETERS, "the law's parameters are no short mapping")
    for name in names:
        demand(
            isinstance(name, str) and NAME.fullmatch(name) and not TAKEN.fullmatch(name),
            f"{quoted(name)} cannot be the name of a parameter of the law",
        )
    count = [0]
    _check_tree(law["after"], names, LEVELS, count)
    return count[0]


def _check_tree(tree: Any, names: Mapping[str, Any], levels: int, count: list[int]) -> None:
    count[0] += 1
    demand(levels > 0 and count[0] <= NODES, "the law is too large")
    if isinstance(tree, str):
        if tree != "v" and tree not in names:
            text_of_double(tree)
        return
    demand(isinstance(tree, list) and tree, "the law has a node that is neither text nor list")
    head, rest = tree[0], tree[1:]
    if head == "if":
        demand(len(rest) == 3 and isinstance(rest[0], list) and len(rest[0]) == 3, "the law has a strange if")
        demand(rest[0][0] in COMPARISONS, f"the law compares by {quoted(rest[0][0])}")
        rest = [*rest[0][1:], *rest[1:]]
    else:
        arity = {"+": (2,), "-": (1, 2), "*": (2,), "/": (2,), "^": (2,), "abs": (1,)}
        demand(isinstance(head, str) and len(rest) in arity.get(head, ()), f"the law has a strange node {quoted(head)}")
    for one in rest:
        _check_tree(one, names, levels - 1, count)


class Jet(NamedTuple):
    """A number with its derivatives by the velocity before the impact and by the unknown parameter."""

    x: Ball
    by_v: Ball
    by_p: Ball


def constant(x: Ball) -> Jet:
    """Return a number that depends on nothing."""
    return Jet(x, number(0), number(0))


def evaluate(tree: Any, leaves: Mapping[str, Jet]) -> Jet:
    """Return the value of a tree and its derivatives, over all numbers in the balls of its leaves.

    One branch of every ``if`` must be the right one over all of the ball, and nothing may be taken the modulus of that
    changes its sign there: so the law is smooth on it.
    """
    if isinstance(tree, str):
        return leaves[tree] if tree in leaves else constant(double(float.fromhex(tree)))
    head = tree[0]
    if head == "if":
        (how, one, two), yes, no = tree[1:]
        side = _side(evaluate(one, leaves).x - evaluate(two, leaves).x)
        held = {"<": side < 0, "<=": side <= 0, ">": side > 0, ">=": side >= 0, "==": side == 0}[how]
        return evaluate(yes if held else no, leaves)
    a = evaluate(tree[1], leaves)
    if head == "abs":
        return a if _side(a.x) >= 0 else _scaled(a, number(-1))
    if len(tree) == 2:
        return _scaled(a, number(-1))
    b = evaluate(tree[2], leaves)
    if head == "+":
        return Jet(*(x + y for x, y in zip(a, b, strict=True)))
    if head == "-":
        return Jet(*(x - y for x, y in zip(a, b, strict=True)))
    if head == "*":
        return Jet(a.x * b.x, a.by_v * b.x + a.x * b.by_v, a.by_p * b.x + a.x * b.by_p)
    if head == "/":
        ratio = a.x / b.x
        return Jet(ratio, (a.by_v - ratio * b.by_v) / b.x, (a.by_p - ratio * b.by_p) / b.x)
    return _power(a, b, _whole(tree[2]))


def _side(x: Ball) -> int:
    """Return the sign that all numbers of a ball have."""
    if x.is_zero():
        return 0
    if not (x > 0 or x < 0):
        raise Rejected("a comparison in the reset law is not certain over the box")
    return 1 if x > 0 else -1


def _scaled(a: Jet, factor: Ball) -> Jet:
    return Jet(factor * a.x, factor * a.by_v, factor * a.by_p)


def _whole(tree: Any) -> int | None:
    """Return the exponent that a tree is, if it is a whole number."""
    if isinstance(tree, list) and len(tree) == 2 and tree[0] == "-":
        under = _whole(tree[1])
        return None if under is None else -under
    if not (isinstance(tree, str) and tree.startswith(("0x", "-0x"))):
        return None
    exponent = float.fromhex(tree)
    return int(exponent) if exponent.is_integer() and abs(exponent) <= EXPONENT else None


def _power(a: Jet, b: Jet, whole: int | None) -> Jet:
    """Return a^b: a product for a whole exponent, else e^(b log a) of an a > 0."""
    demand(a.x.is_finite(), "the reset law has a power of what need not be a number")  # its power 0 would be 1
    if whole is not None:
        exponent = abs(whole)
        value, slope = a.x**exponent, exponent * a.x ** max(exponent - 1, 0)
        if whole < 0:
            value, slope = 1 / value, -slope / (value * value)
        return Jet(value, slope * a.by_v, slope * a.by_p)
    demand(a.x > 0, "the reset law has a power of what is not surely > 0")
    log = a.x.log()
    value = (b.x * log).exp()
    slope = b.x * value / a.x
    return Jet(value, slope * a.by_v + value * log * b.by_v, slope * a.by_p + value * log * b.by_p)


def law_text(tree: Any) -> str:
    """Return a tree as a formula.

    Examples
    --------
    >>> law_text(["+", ["*", ["-", "r"], "v"], ["if", [">=", ["-", "v"], "0x1.0p-1"], "V", "0x0.0p+0"]])
    '(-p.r)*v + (p.V if -v >= 0.5 else 0.0)'
    """
    return _text(tree, 0)


def law_values(law: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a law in the order in which its formula names them, then any others by their names."""
    named = re.findall(r"\bp\.(\w+)", law_text(law["after"]))
    return {name: law["parameters"][name] for name in dict.fromkeys([*named, *sorted(law["parameters"])])}


#: How tightly nodes bind, in a formula; a minus sign as loosely as a sum.
BINDS = {"+": 1, "-": 1, "*": 2, "/": 2, "^": 3}


def _text(tree: Any, outside: int) -> str:
    """Return a formula, in parentheses if it binds no more tightly than what is outside."""
    if isinstance(tree, str):
        if tree == "v":
            return "v"
        if NAME.fullmatch(tree):
            return f"p.{tree}"
        x = float.fromhex(tree)
        return f"({x!r})" if outside and tree.startswith("-") else repr(x)
    head = tree[0]
    if head == "if":
        (how, one, two), yes, no = tree[1:]
        return f"({_text(yes, 0)} if {_text(one, 0)} {how} {_text(two, 0)} else {_text(no, 0)})"
    if head == "abs":
        return f"abs({_text(tree[1], 0)})"
    rank = BINDS[head]
    if len(tree) == 2:
        said = f"-{_text(tree[1], rank + 1)}"
    else:
        space = " " if rank == 1 else ""
        # a - (b - c) and a/(b/c) need their parentheses, (a - b) - c and (a^b)^c get what they need
        left = _text(tree[1], rank if head == "^" else rank - 1)
        said = f"{left}{space}{head}{space}{_text(tree[2], rank)}"
    return f"({said})" if outside >= rank else said
