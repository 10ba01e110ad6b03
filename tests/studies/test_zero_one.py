"""The 0-1 test: known regular and chaotic series, its definition, and what it refuses."""

import numpy as np
import pytest

import grazing as gz
from grazing.studies.zero_one import SHORTEST, zero_one
from tests.studies.maps import HENON, SMOOTH

T = np.arange(3000)


def logistic(a, n=3000):
    return SMOOTH.replace(a=a).iterate((0.3,), n + 500)[501:, 0]


@pytest.mark.parametrize("a", [3.97, 4.0, 3.7, 3.9])
def test_chaos_is_near_one(a):
    assert zero_one(logistic(a)) > 0.9


@pytest.mark.parametrize(
    "series",
    [
        lambda: np.sin(2 * np.pi * 0.1234567 * T),
        lambda: np.sin(2 * np.pi * 0.1234567 * T) + 0.5 * np.cos(2 * np.pi * np.sqrt(2) * T),
        lambda: logistic(3.2),
        lambda: logistic(3.55),
        lambda: logistic(3.83),
        lambda: gz.gap_map(0.5, 0.07, 0.1).iterate((0.1,), 3500)[501:, 0],
        lambda: 1e6 + np.sin(T),
        lambda: 1e-6 * np.sin(T),
    ],
    ids=["one tone", "two tones", "period 2", "period 8", "period 3", "gap map", "large mean", "small"],
)
def test_regular_motion_is_near_zero(series):
    assert abs(zero_one(series())) < 0.1


def test_it_agrees_with_the_exponent_on_maps():
    for P, chaotic in (
        (gz.gap_map(0.9, 0.1, 0.0), True),
        (gz.gap_map(0.8, 0.5, 1.0), False),
        (HENON, True),
        (HENON.replace(a=0.9), False),
    ):
        x = P.iterate([0.05] * P.dimension, 4000)[1000:, 0]
        assert (gz.lyapunov(P, starts=1, transient=1000).exponent.values.max() > 0) == chaotic
        assert (zero_one(x) > 0.5) == chaotic


@pytest.mark.parametrize("far", [-0.5, 100.0, 1e3, 1e6])
def test_the_origin_of_the_observable_does_not_matter(far):
    for x in (logistic(4.0, 1000), logistic(3.55, 1000)):
        assert zero_one(x + far) == pytest.approx(zero_one(x), abs=1e-6)


def test_noise_counts_as_chaos_and_a_constant_as_regular():
    rng = np.random.default_rng(0)
    assert zero_one(rng.normal(size=3000)) > 0.9
    assert zero_one(np.full(200, 3.7)) == 0.0
    assert zero_one(np.zeros(200)) == 0.0


def by_definition(x, c):
    """Gottwald and Melbourne (2009): K_c from loops, of the series without its mean."""
    n, x = len(x), np.asarray(x) - np.mean(x)
    p = np.array([sum(x[j] * np.cos((j + 1) * c) for j in range(m)) for m in range(1, n + 1)])
    q = np.array([sum(x[j] * np.sin((j + 1) * c) for j in range(m)) for m in range(1, n + 1)])
    most = n // 10
    lags, D = np.arange(1, most + 1), []
    for lag in lags:
        total = [(p[j + lag] - p[j]) ** 2 + (q[j + lag] - q[j]) ** 2 for j in range(n - most)]
        D.append(np.mean(total))
    return np.corrcoef(lags, D)[0, 1]


def test_its_definition():
    from grazing.kernel.random import uniform

    x = logistic(3.9, 150)
    c = np.pi * (0.2 + 0.6 * uniform(3, (), 5, 1)[:, 0])
    assert zero_one(x, frequencies=5, seed=3) == pytest.approx(
        np.median([by_definition(x, one) for one in c]), abs=1e-12
    )


def test_many_series_are_each_their_own():
    both = np.column_stack([logistic(3.9), logistic(3.2), np.full(3000, np.nan)])
    found = zero_one(both)
    assert found.shape == (3,)
    assert found[0] == zero_one(both[:, 0]) and found[1] == zero_one(both[:, 1])
    assert np.isnan(found[2]) and isinstance(zero_one(both[:, 0]), float)
    assert zero_one(both[:, :0]).shape == (0,)
    with_inf = logistic(3.9)
    with_inf[7] = np.inf
    assert np.isnan(zero_one(with_inf))


def test_shift_scale_and_seed():
    x = logistic(3.9)
    assert zero_one(7.0 * x) == pytest.approx(zero_one(x), abs=1e-9)
    assert zero_one(x, seed=1) != zero_one(x, seed=2)
    assert zero_one(x.tolist()) == zero_one(x)


def test_series_of_extreme_size():
    x = logistic(3.9)
    for scale in (1e-200, 1e200):
        assert zero_one(scale * x) == pytest.approx(zero_one(x), abs=1e-6)


@pytest.mark.parametrize(
    ("series", "more", "said"),
    [
        (np.zeros(SHORTEST - 1), {}, r"the series has shape \(99,\); give \(n,\) or \(n, m\) with n >= 100"),
        (3.0, {}, r"the series has shape \(\); give"),
        (np.zeros((200, 2, 2)), {}, r"the series has shape \(200, 2, 2\)"),
        ("chaos", {}, "the series is not numbers; give an array"),
        ([[1.0], [1.0, 2.0]], {}, "the series is not numbers"),
        (np.zeros(200, complex) + 1j, {}, "the series is not numbers"),
        (np.zeros(200), {"frequencies": 0}, "frequencies = 0; allowed is a whole number >= 1"),
        (np.zeros(200), {"seed": -1}, "seed = -1; allowed"),
        (None, {}, "give"),
    ],
    ids=["short", "number", "three axes", "text", "ragged", "complex", "frequencies", "seed", "none"],
)
def test_error_texts(series, more, said):
    with pytest.raises(gz.InputError, match=said):
        zero_one(series, **more)
