"""The schema: every certificate that is made fits, and what does not fit is refused by the checker."""

import json
from importlib.resources import files

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from grazing_checker import Rejected, check
from grazing_checker.check import KINDS
from grazing_checker.law import COMPARISONS, TAKEN, check_law
from grazing_checker.reading import text_of_double
from tests.examples import examples
from tests.grazing_checker.bases import bases
from tests.grazing_checker.documents import alike, at, changed, documents, leaves, resealed

SCHEMA = json.loads((files("grazing_checker") / "schema.json").read_text())
WHOLE = Draft202012Validator(SCHEMA)


def part(name):
    """The validator of one definition."""
    return Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]})


def test_the_schema_is_one_and_knows_all_kinds():
    Draft202012Validator.check_schema(SCHEMA)
    assert set(SCHEMA["properties"]["kind"]["enum"]) == set(KINDS)
    assert {kind.replace(" ", "-") for kind in KINDS} <= set(SCHEMA["$defs"])


def test_every_certificate_that_is_made_fits():
    for name, document in bases().items():
        assert not [error.message for error in WHOLE.iter_errors(document)], name


def test_nothing_may_be_added_anywhere_and_nothing_left_out():
    seen = set()  # one part of the schema: mappings of one kind of certificate, in one place, with one set of keys
    for document in bases().values():
        kinds = [document["kind"], *(document["data"].get(name) for name in ("type", "edge"))]
        places = dict.fromkeys(path[:i] for path in leaves(document) for i in range(len(path)))
        for place in alike(places):
            value = at(document, place)
            if not isinstance(value, dict) or place[-1:] == ("parameters",):
                continue
            called = tuple("*" if isinstance(part, int) else part for part in place)
            if (part := (*kinds, value.get("kind"), called, frozenset(value))) in seen:
                continue
            seen.add(part)
            assert not WHOLE.is_valid(changed(document, place, lambda old: {**old, "more": "0x1p0"}))
            for key in value:
                less = changed(document, place, lambda old, key=key: without(old, key))
                assert not WHOLE.is_valid(less), (place, key)


def without(mapping, key):
    return {name: value for name, value in mapping.items() if name != key}


VALUES = [
    None, True, 0, 1, -1, 1.5, 2**70, "", "v", "x", "0x0p0", "-0x1p0", "0x1p0", "inf", "nan", "1.5", "0x1.8p0", "1e5",
    (-1.0).hex(), (0.0).hex(), (-0.0).hex(), "0x1p-9999999", [], ["0x1p0"], {}, {"x": 1}, "stable", "THEREFORE", "ns",
]  # fmt: skip
STRANGE = st.sampled_from(VALUES)


@given(st.data())
@settings(max_examples=examples(400))
def test_what_the_schema_refuses_the_checker_refuses_too(data):
    document = bases()[data.draw(st.sampled_from(sorted(bases())))]
    paths = [path for path in leaves(document) if path[0] in ("data", "inequalities", "kind")]
    path = data.draw(st.sampled_from(paths))
    value, old = data.draw(STRANGE), at(document, path)
    if isinstance(old, str) and data.draw(st.booleans()):
        near = [f"-{old}", f"{old}0", f" {old}", f"{old}\n", old.upper(), old.replace("p", "P")]
        value = data.draw(st.sampled_from(near))
    forged = changed(document, path, lambda _old: value)
    if not WHOLE.is_valid(forged):
        with pytest.raises(Rejected):
            check(resealed(forged))


LEAVES = st.sampled_from(["v", "r", "V", "alpha", "cos1", "w", "0x1p0", (0.5).hex(), (-2.0).hex(), "inf", 1, None])
TREES = st.recursive(
    LEAVES,
    lambda trees: st.tuples(
        st.sampled_from(["+", "-", "*", "/", "^", "abs", "if", "sin", *COMPARISONS]), st.lists(trees, max_size=3)
    ).map(lambda x: [x[0], *x[1]]),
    max_leaves=8,
)


@given(TREES)
@settings(max_examples=examples(400))
def test_the_schema_of_laws_refuses_no_law_that_the_checker_takes(tree):
    try:
        check_law({"parameters": {"r": None, "V": None}, "after": tree})
    except Rejected:
        return
    assert part("expression").is_valid(tree)


@given(
    st.sampled_from(
        ["alpha", "k", "r", "cos1", "sin12", "cosine", "d", "dd", "v", "V", "T", "e_2", "_e", "", "é", "a b"]
    )
)
def test_the_schema_takes_the_names_that_the_checker_takes(name):
    try:
        check_law({"parameters": {name: None}, "after": "v"})
        taken = True
    except Rejected:
        taken = False
    assert part("parameter-of-the-law").is_valid(name) == taken
    assert not (taken and TAKEN.fullmatch(name))


NEAR_DOUBLES = st.floats(allow_nan=False, allow_infinity=False).map(float.hex) | st.from_regex(
    r"\A-?0x[012]\.[0-9a-f]{1,14}p[+-]?[0-9]{1,4}\Z"
)
POSITIVE, NOT_NEGATIVE = (lambda x: x > 0.0), (lambda x: x >= 0.0)


@given(NEAR_DOUBLES)
@example("0x1.0p+0")
@example("0x0.0000000000000p-1022")
@example("0x0.0000000000001p-1022")
@example("0x0.0000000000001p-1021")
@example("0x1.0000000000000p-1023")
@example("0x1.fffffffffffffp+1023")
@example("0x1.0000000000000p+1024")
@example("0x1.0000000000000p-0")
@example("0x1.0000000000000p+00")
@example("-0x0.0p+0")
def test_the_schema_takes_the_doubles_that_the_checker_takes(text):
    for name, allowed in (("double", None), ("double-positive", POSITIVE), ("double-not-negative", NOT_NEGATIVE)):
        try:
            x = text_of_double(text)
            taken = allowed is None or allowed(x)
        except Rejected:
            taken = False
        assert part(name).is_valid(text) == taken, name


@pytest.mark.parametrize("zero", ["0x0p7", "-0x0p0", "0x000p-3", "0x0p-0"])
@pytest.mark.parametrize("kind", ["pd", "gr", "lp", "ns"])
def test_the_half_width_along_the_curve_at_its_ends_is_one_text(kind, zero):
    """No other text for 0: what the schema refuses, the checker refuses."""
    document = documents()[kind]
    forged = changed(document, ("data", "ends", 1, "radius", document["data"]["pinned"]), lambda _old: zero)
    assert not WHOLE.is_valid(forged)
    with pytest.raises(Rejected, match="not at the end"):
        check(resealed(forged))
