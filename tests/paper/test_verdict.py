import json

import pytest

from grazing.paper.claims import Claim, Verdict, agree, claim, step_of


@pytest.mark.parametrize(
    ("claimed", "computed", "expected"),
    [
        ("0.17", 0.181577, False),
        ("0.22", 0.224377, True),
        ("0.22", 0.225001, False),
        ("0.135", 0.1309618694, False),
        ("0.130961869350", 0.13096186934990559, True),
        ("2", 2, True),
        ("2", 3, False),
        ("0", 0.4, True),  # rounds to 0: an integer is printed without digits
        ("0.0", 0.4, False),
        (True, True, True),
        (True, False, False),
        (True, 1, False),
        ("LLR", "LLR", True),
        ("LLR", "LR", False),
        ([1, "0"], [1, "0"], True),
        ([1, 2], [1, 2, 3], False),
        ([1, 2], 1, False),
        ("0.5", float("nan"), False),
        ("0.5", float("inf"), False),
        ("0.5", None, False),
    ],
)
def test_equal_after_rounding_to_the_digits_printed(claimed, computed, expected):
    assert agree(claimed, computed) is expected


def test_a_tolerance_replaces_the_digits():
    assert agree("0.5", 0.515, 0.02)
    assert not agree("0.5", 0.525, 0.02)
    assert agree([1, 2], [1.01, 1.99], 0.1)


def test_the_step_is_the_last_printed_digit():
    assert float(step_of("0.17")) == 0.01
    assert float(step_of("0.130")) == 0.001
    assert float(step_of("3")) == 1.0
    assert Claim("a", "b", "c", "0.17", 0.17).allowed == 0.005


def test_the_verdict_follows_from_the_values():
    said = {"id": "x", "where": "section 1", "claim": "says"}
    assert Claim(**said, claimed="0.17", computed=0.171).verdict is Verdict.agrees
    assert Claim(**said, claimed="0.17", computed=0.181).verdict is Verdict.differs
    assert Claim(**said, claimed="0.17", computed=0.181, slip=3).verdict is Verdict.corrected
    # a slip that turns out to be none is not called one
    assert Claim(**said, claimed="0.17", computed=0.171, slip=3).verdict is Verdict.agrees


def test_a_record_is_plain_json():
    import numpy as np

    record = claim("x", "here", "says", "0.5", np.float64("inf"), note="n").record()
    assert json.loads(json.dumps(record, allow_nan=False))["computed"] == "inf"
    assert set(record) == {"id", "where", "claim", "claimed", "computed", "tolerance", "slip", "note", "verdict"}
    assert claim("x", "here", "says", [1], np.array([1])).record()["computed"] == [1]
