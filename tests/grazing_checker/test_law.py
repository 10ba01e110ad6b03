"""Laws as expressions: what the checker evaluates, prints and refuses."""

import math
import re
from types import SimpleNamespace

import pytest
from flint import arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from grazing.proof.expression import in_doubles
from grazing_checker import check
from grazing_checker.balls import number, precision
from grazing_checker.law import COMPARISONS, LEVELS, NODES, TAKEN, Jet, check_law, evaluate, law_text
from grazing_checker.reading import Rejected
from tests.examples import examples
from tests.grazing_checker.documents import changed, claiming, documents

ONE, TWO = (1.0).hex(), (2.0).hex()
NUMBERS = st.floats(-8.0, 8.0).map(lambda x: round(x, 2)).map(float.hex)
LEAVES = st.sampled_from(["v", "r", "V"]) | NUMBERS


def grown(trees):
    pairs = st.tuples(trees, trees)
    return st.one_of(
        st.tuples(st.sampled_from("+-*/"), pairs).map(lambda x: [x[0], *x[1]]),
        st.tuples(st.sampled_from(["-", "abs"]), trees).map(list),
        st.tuples(trees, st.integers(-3, 4)).map(lambda x: ["^", x[0], float(x[1]).hex()]),
        st.tuples(st.sampled_from(COMPARISONS), pairs, pairs).map(lambda x: ["if", [x[0], *x[1]], *x[2]]),
    )


TREES = st.recursive(LEAVES, grown, max_leaves=12)


def jets(v, r, V, radius=0.0):
    ball = arb(v, radius)
    return {"v": Jet(ball, arb(1), arb(0)), "r": Jet(arb(r), arb(0), arb(1)), "V": Jet(arb(V), arb(0), arb(0))}


@given(TREES, st.floats(-3.0, -0.01), st.floats(0.1, 0.9))
@settings(max_examples=examples(300))
def test_balls_hold_what_doubles_give_and_slopes_are_those_of_small_steps(tree, v, r):
    check_law({"parameters": {"r": None, "V": None}, "after": tree})
    h = arb(2) ** -80
    with ctx.workprec(400):
        try:
            after = evaluate(tree, jets(v, r, 0.5))
            wide = evaluate(tree, jets(v, r, 0.5, 1e-9))
            by_v = [evaluate(tree, jets(arb(v) + s * h, r, 0.5)).x for s in (-1, 1)]
            by_p = [evaluate(tree, jets(v, arb(r) + s * h, 0.5)).x for s in (-1, 1)]
        except Rejected:
            return
        if not all(x.is_finite() for x in (*after, *wide, *by_v, *by_p)) or abs(after.x) > 1e30:
            return
        assert wide.x.contains(after.x) and wide.by_v.contains(after.by_v)
        size = 1 + abs(after.x) + abs(after.by_v) + abs(after.by_p)
        third = arb(2) ** -60 * size**8  # what the step of 2^-80 leaves out
        assert abs((by_v[1] - by_v[0]) / (2 * h) - after.by_v) < third
        assert abs((by_p[1] - by_p[0]) / (2 * h) - after.by_p) < third


@given(TREES, st.floats(-3.0, -0.01))
@settings(max_examples=examples(300))
def test_the_text_of_a_law_means_what_its_tree_means(tree, v):
    """Read by Python, with its own rules of precedence, it gives the same double."""

    def outcome(call):
        try:
            return repr(float(call()))
        except (ZeroDivisionError, OverflowError) as error:
            return type(error).__name__

    text, names = law_text(tree).replace("^", "**"), {"v": v, "p": SimpleNamespace(r=0.7, V=0.3)}
    assert outcome(lambda: eval(text, names)) == outcome(lambda: in_doubles(tree, {"v": v, "r": 0.7, "V": 0.3}))


@pytest.mark.parametrize("how", COMPARISONS)
def test_a_comparison_must_be_certain(how):
    tree = ["if", [how, "v", (-0.5).hex()], ONE, TWO]
    with pytest.raises(Rejected, match="not certain over the box"):
        evaluate(tree, jets(-0.5, 0.5, 0.5, 1e-30))
    held = {"<": False, "<=": True, ">": False, ">=": True, "==": True}[how]
    assert float(evaluate(tree, jets(-0.5, 0.5, 0.5)).x) == (1.0 if held else 2.0)
    for v, below in ((-0.6, True), (-0.4, False)):
        held = below if how in ("<", "<=") else not below if how in (">", ">=") else False
        assert float(evaluate(tree, jets(v, 0.5, 0.5, 0.01)).x) == (1.0 if held else 2.0)


def test_a_modulus_or_a_power_at_zero_is_refused_and_a_whole_power_is_not():
    for tree in (["abs", "v"], ["^", ["-", "v"], "r"], ["^", "v", (0.5).hex()], ["^", "v", (101.0).hex()]):
        with pytest.raises(Rejected):
            evaluate(tree, jets(0.0, 0.5, 0.5, 1e-30))
    square = evaluate(["^", "v", TWO], jets(-2.0, 0.5, 0.5))
    assert (float(square.x), float(square.by_v)) == (4.0, -4.0)
    assert not evaluate(["/", ONE, "v"], jets(0.0, 0.5, 0.5, 1e-30)).x.is_finite()
    root = evaluate(["^", ["-", "v"], "r"], jets(-2.0, 0.5, 0.5))
    assert math.isclose(float(root.x), 2**0.5) and math.isclose(float(root.by_p), 2**0.5 * math.log(2))


def of_itself(trees):
    """What a forger builds from one tree: nothing, one, and what is neither where the tree is 0 or undefined."""
    zero = (0.0).hex()

    def ways(a, how):
        found = ["-", a, a], ["*", zero, a], ["/", a, a], ["^", a, zero], ["^", zero, a], ["/", a, zero], ["abs", a]
        power = ["^", ["/", a, zero], zero]
        return [*found, ["if", [how, a, a], a, ONE], ["if", [how, power, TWO], a, "v"]]

    return st.tuples(trees, st.sampled_from(COMPARISONS), st.integers(0, 8)).map(lambda x: ways(*x[:2])[x[2]])


FORGED = st.recursive(LEAVES, lambda trees: grown(trees) | of_itself(trees), max_leaves=8)
LITERAL = re.compile(r"(?<![\w.])(\d+\.?\d*(?:e[+-]?\d+)?)")


@given(FORGED, st.sampled_from([-0.5, -1.0, -0.7]), st.sampled_from([8, 40, 200]), st.floats(-0.999, 0.999))
@settings(max_examples=examples(400))
def test_a_law_that_is_taken_is_defined_and_smooth_as_its_formula_reads(tree, v, bits, share):
    """The formula alone, read in 150 digits: nothing in it is undefined, and value and slope lie in their balls."""
    check_law({"parameters": {"r": None, "V": None}, "after": tree})
    with precision(256):
        try:
            after = evaluate(tree, jets(v, 0.7, 0.3, number(1, -bits)))
        except Rejected:
            return
        if not all(x.is_finite() for x in after):
            return
    code = compile(LITERAL.sub(r"mpf(\1)", law_text(tree).replace("^", "**")), "law", "eval")
    with mp.workdps(300), precision(800):
        here, h, size = v + share * mpf(2) ** -bits, mpf(10) ** -120, mpf(10) ** -60

        def value(x):
            return +mpf(eval(code, {"mpf": mpf, "v": x, "p": SimpleNamespace(r=mpf(0.7), V=mpf(0.3))}))

        for ball, x in ((after.x, value(here)), (after.by_v, (value(here + h) - value(here - h)) / (2 * h))):
            low, high = (
                mpf(int(m)) * mpf(2) ** int(e) for m, e in (end.man_exp() for end in (ball.lower(), ball.upper()))
            )
            room = size * (1 + abs(x) + abs(low))
            assert low - room <= x <= high + room


NO_NUMBERS = [["/", ONE, ["-", "r", "r"]], ["/", "v", (0.0).hex()], ["^", (0.0).hex(), (-1.0).hex()]]


@pytest.mark.parametrize("what", NO_NUMBERS)
def test_the_power_0_of_what_is_no_number_is_none(what):
    """A ball around nothing to the power 0 is 1: the law would have a value where its sentence has none."""
    power = ["^", what, (0.0).hex()]
    for tree in (power, ["if", ["<", power, TWO], ONE, "v"], ["+", ONE, ["*", (0.0).hex(), power]]):
        with pytest.raises(Rejected, match="need not be a number"):
            evaluate(tree, jets(-0.5, 0.5, 0.5, 1e-30))


NO_NAMES = [
    "alpha", "k", "omega", "t0", "offset", "d", "sigma", "v", "cos1", "sin1", "cos7", "sin12", "", "p.r", "_r", "r;",
    "r = 1", "1r", "é", "r" * 41, "0x1p0", "r\n", "newton with r = 0.5; THEREFORE every orbit of it is stable (law",
]  # fmt: skip


@pytest.mark.parametrize("name", NO_NAMES)
def test_no_parameter_of_a_law_has_a_name_of_the_model_or_one_that_is_text(name):
    with pytest.raises(Rejected, match="cannot be the name"):
        check_law({"parameters": {name: ONE}, "after": ONE})


def test_every_name_of_a_model_is_taken():
    import grazing as gz

    for model in (gz.pinball(), gz.Oscillator(1.0, 1.0, gz.Forcing(1.0, cos=(1.0,) * 12), gz.newton(0.5))):
        law = set(model.reset.params)
        assert all(TAKEN.fullmatch(name) for name in model.params if name not in law)
        assert not any(TAKEN.fullmatch(name) for name in law)


def nested(levels):
    tree = "v"
    for _ in range(levels):
        tree = ["-", tree]
    return tree


def bushy(levels):
    return "v" if levels == 0 else ["+", bushy(levels - 1), bushy(levels - 1)]


@pytest.mark.parametrize(
    "tree",
    [
        "w", "", "inf", "nan", "1.5", "0x1p0", 1.0, 1, True, None, {}, [], ["v"], ["sin", "v"], ["+", "v"],
        ["+", "v", "v", "v"], ["-"], ["abs", "v", "v"], ["if", "v", "v", "v"], ["if", ["<", "v"], "v", "v"],
        ["if", ["!=", "v", "v"], "v", "v"], ["<", "v", "v"], [["+"], "v", "v"], ["^", "v"],
        ["if", ["<", "v", "v"], "v"],
        nested(LEVELS + 1), bushy(NODES.bit_length()), ["__import__", "v"], ["+", "v", "os.system"],
    ],
)  # fmt: skip
def test_what_is_no_expression_is_refused(tree):
    with pytest.raises(Rejected):
        check_law({"parameters": {"r": ONE}, "after": tree})


@pytest.mark.parametrize("law", [{}, {"parameters": {}}, {"parameters": [], "after": "v"}, 3, None, "newton"])
def test_what_is_no_law_is_refused(law):
    with pytest.raises(Rejected):
        check_law(law)


def test_the_largest_law_is_evaluated_and_printed_in_time():
    tree = nested(LEVELS - 1)
    check_law({"parameters": {}, "after": tree})
    assert float(evaluate(tree, jets(-1.0, 0.5, 0.5)).x) == (-1.0) ** LEVELS
    assert law_text(tree).count("-") == LEVELS - 1


def test_the_numbers_in_a_law_are_said_to_be_doubles():
    """Printed in decimals, a tenth is another number than the double: with it the orbit would lie outside its box."""
    document = documents()["stable"]
    r, V = (float.fromhex(document["data"]["law"]["parameters"][name]).hex() for name in ("r", "V"))
    law = {"parameters": {}, "after": ["+", ["*", ["-", r], "v"], V]}
    said = check(claiming(changed(document, ("data", "law"), lambda _old: law)))
    formula = f"(-{float.fromhex(r)!r})*v + {float.fromhex(V)!r}"
    assert f"makes u' = {formula}, all parameters and the numbers in the law taken as these exact doubles, " in said
