"""Many columns at once: one map's numbers do not depend on the others; wrong requests are refused in words."""

import numpy as np
import pytest

import grazing as gz
from grazing import memory
from grazing.maps import columns
from grazing.maps.columns import empty_columns, size_of_columns
from grazing.outcome import DIVERGED, NO_IMPACT

G = gz.gap_map(lam=0.5, mu=0.1, l=0.1)


def spiral(state, p):
    """A step with three coordinates, a letter and an outcome; beyond |x| = 4 it ends."""
    x, y, n = state
    return (p.a * x - p.b * y, p.b * x + p.a * y, n + 1.0), int(x > 0.0), (NO_IMPACT if abs(x) > 4.0 else 0)


S = gz.Map(spiral, {"a": 0.8, "b": 0.6}, ("x", "y", "n"), ((-1.0, 1.0), (-1.0, 1.0), (0.0, 1.0)))
SPIRALS = np.array([[0.8, 0.6], [0.9, 0.6], [1.1, -0.3], [0.2, 0.1], [0.0, 2.0]])
STARTS = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 3, 7))


def equal(one, two):
    return all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in zip(one, two, strict=True))


@pytest.mark.parametrize("tile", [1, 30, 1_000_000])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("transient", "keep", "records"), [(0, 6, 6), (5, 4, 1), (4, 3, 3), (6, 0, 1)])
def test_every_column_is_its_own_run(monkeypatch, tile, threads, transient, keep, records):
    """Whatever the size of a tile and the number of threads."""
    monkeypatch.setattr(columns, "TILE", tile)
    lanes = STARTS.copy()
    found = S.run_columns(
        SPIRALS, lanes, transient, keep, records=records, arithmetic="strict", threads=threads
    )  # fmt: skip
    for q, (a, b) in enumerate(SPIRALS.tolist()):
        for i in range(7):
            alone = S.replace(a=a, b=b).orbit(STARTS[q, :, i], transient + keep)
            points, outcomes = alone.points[1:], alone.outcomes
            assert np.array_equal(found.points[q, :, :, i], points[transient:], equal_nan=True)
            assert np.array_equal(lanes[q, :, i], points[-1], equal_nan=True)
            assert np.array_equal(found.letters[q, :, i], alone.letters[transient:])
            if records == 1:
                assert found.outcomes[q, 0, i] == np.bitwise_or.reduce(outcomes)
            else:
                assert np.array_equal(found.outcomes[q, 1:, i], outcomes[transient + 1 :])
                assert found.outcomes[q, 0, i] == np.bitwise_or.reduce(outcomes[: transient + 1])
    assert (found.outcomes & NO_IMPACT).any()
    assert np.isinf(found.near_miss).all() and np.isinf(found.slowest).all() and not found.undecided.any()


def test_a_run_continues_from_its_last_states():
    lanes = STARTS.copy()
    whole = S.run_columns(SPIRALS, lanes.copy(), 0, 12, arithmetic="strict", threads=1)
    first = S.run_columns(SPIRALS, lanes, 0, 5, arithmetic="strict", threads=1)
    second = S.run_columns(SPIRALS, lanes, 0, 7, arithmetic="strict", threads=1)
    assert np.array_equal(np.concatenate([first.points, second.points], axis=1), whole.points, equal_nan=True)
    assert np.array_equal(np.concatenate([first.letters, second.letters], axis=1), whole.letters)


@pytest.mark.parametrize(
    "make", [lambda a: a[:, :, ::2], lambda a: np.asfortranarray(a), lambda a: a.astype(np.float32)]
)
def test_lanes_of_any_layout_hold_the_last_states(make):
    lanes = make(STARTS.copy())
    packed = np.ascontiguousarray(lanes, np.float64)
    assert lanes is not packed
    S.run_columns(SPIRALS, packed, 3, 0, arithmetic="strict", threads=1)
    S.run_columns(SPIRALS, lanes, 3, 0, arithmetic="strict", threads=1)
    assert np.array_equal(lanes, packed.astype(lanes.dtype), equal_nan=True)


def test_orbits_that_left_the_numbers_are_marked():
    P = gz.Map(lambda s, p: (p.a * s[0] * s[0],), {"a": 4.0}, escape=1e300)
    found = P.run_columns([[4.0], [1.0]], np.array([[[0.1, 3.0]], [[0.1, 0.9]]]), 20, 2)
    assert (found.outcomes[:, 0] & DIVERGED != 0).tolist() == [[False, True], [False, False]]


def test_progress_ends_with_the_total():
    for threads in (1, 2):
        said = []
        G.run_columns(np.tile([0.5, 0.1, 0.1], (30, 1)), np.zeros((30, 1, 5000)), 50, 1, threads=threads,
                      progress=lambda *now, said=said: said.append(now))  # fmt: skip
        assert said[-1][0] == said[-1][1] == max(total for _, total in said)


@pytest.mark.parametrize("P", [G, gz.stroboscopic_map(gz.pinball())], ids=["gap", "oscillator"])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("n", "starts"), [(0, 3), (2, 0), (0, 0)])
def test_no_columns_and_no_starts_are_no_work(P, threads, n, starts):
    rows = np.tile(list(P.params.values()), (n, 1)).reshape(n, len(P.params))
    found = P.run_columns(rows, np.zeros((n, P.dimension, starts)), 1, 2, threads=threads)
    assert found.points.shape == (n, 2, P.dimension, starts)
    assert found.undecided.shape == (n, starts)


# ---- what is refused

ROW = [[0.5, 0.1, 0.1]]
NEEDS = r"gap map needs \(columns, 3\): lam, mu, l; and \(columns, 1, n\): x"


@pytest.mark.parametrize(
    ("rows", "shape", "words"),
    [
        ([[0.5, 0.1]], (1, 1, 4), rf"rows have shape \(1, 2\) and lanes \(1, 1, 4\); {NEEDS}"),
        (ROW, (2, 1, 4), rf"rows have shape \(1, 3\) and lanes \(2, 1, 4\); {NEEDS}"),
        (ROW, (1, 2, 4), rf"rows have shape \(1, 3\) and lanes \(1, 2, 4\); {NEEDS}"),
        (ROW, (1, 1), rf"rows have shape \(1, 3\) and lanes \(1, 1\); {NEEDS}"),
        (ROW, (1,), NEEDS),
        ([ROW], (1, 1, 4), NEEDS),
    ],
)
def test_shapes_that_do_not_fit(rows, shape, words):
    with pytest.raises(gz.InputError, match=words):
        G.run_columns(rows, np.zeros(shape), 1, 1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"arithmetic": "quick"}, r"arithmetic is 'quick'; allowed are 'strict' and 'fast'"),
        ({"algorithm": "lanes"}, r"algorithm is 'lanes'; allowed are 'block' and 'scalar'"),
        ({"threads": 0}, r"threads = 0; allowed is a whole number >= 1"),
        ({"keep": -1}, r"keep = -1; allowed is a whole number >= 0"),
        ({"transient": 1.5}, r"transient = 1.5; allowed is a whole number >= 0"),
    ],
)
@pytest.mark.parametrize("P", [G, gz.stroboscopic_map(gz.pinball())], ids=["gap", "oscillator"])
def test_options_that_do_not_exist(P, options, words):
    rows, lanes = [list(P.params.values())], np.full((1, P.dimension, 2), 0.1)
    with pytest.raises(gz.InputError, match=words):
        P.run_columns(rows, lanes, **{"transient": 1, "keep": 1, **options})
    assert (lanes == 0.1).all()


def test_what_would_not_fit_says_how_large_it_is_and_what_stores_less(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 64_000_000)
    P = gz.stroboscopic_map(gz.pinball())
    rows, lanes = np.tile(list(P.params.values()), (100, 1)), np.full((100, 2, 50), 0.1)
    with pytest.raises(gz.InputError) as refused:
        P.run_columns(rows, lanes, 10, 10_000)
    size = size_of_columns(100, 2, 50, 10_000, 1)
    said = str(refused.value)
    assert said.startswith(
        f"the result would take {size / 1e9:.3g} GB, more than half of the memory (0.064 GB); reduce columns (100), "
        "starts (50) or keep (10000)"
    )
    assert "keep=0" in said and "the last states only" in said
    assert (lanes == 0.1).all()


@pytest.mark.parametrize("shape", [(1, 1, 1, 0, 1), (3, 2, 5, 7, 7), (10, 3, 1, 4, 1)])
def test_the_size_that_is_asked_for_is_the_size_that_is_taken(shape):
    """With the starts, which a map that settles ties keeps beside the results."""
    starts = np.empty((shape[0], shape[1], shape[2]))
    assert size_of_columns(*shape) == sum(array.nbytes for array in empty_columns(*shape)) + starts.nbytes
