"""No attracting orbit between windows: proven up to their edges, refused where there is one, true by iteration."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import InputError
from grazing.proof.gap_chaos import prove_no_attractor
from grazing_checker import check
from tests.examples import examples
from tests.theory.naive import iterate, slope

CLOSE = 1e-12


@pytest.mark.parametrize("lam", [0.667, 0.67, 0.7, 0.75, 0.8, 0.9, 0.95, 0.99])
def test_robust_chaos_of_the_paper_is_proven(lam):
    high = theory.robust_chaos(lam).high * (1 - CLOSE)
    proof = prove_no_attractor(lam, 0.0, 0.0, high)
    assert proof.proven, proof.statement
    assert f"every mu in (0.0, {high!r}]" in proof.statement
    assert check(json.loads(json.dumps(proof.document))) == proof.statement
    assert not prove_no_attractor(lam, 0.0, 0.0, theory.robust_chaos(lam).high * (1 + 1e-9)).proven


@pytest.mark.parametrize(("lam", "l"), [(0.9, 0.0), (0.7, 0.0), (0.9, 0.05), (0.9, 0.4), (0.8, 0.3), (0.5, 0.02)])
def test_all_intervals_between_neighbouring_windows_are_proven_and_no_window_is(lam, l):
    gaps = 0
    for N in range(1, 25):
        low, high = theory.mu_bc(N + 1, lam, l), theory.mu_pd(N, lam, l)
        window = theory.stability_interval(N, lam, l)
        if not window.empty:
            inside = window.low + 1e-6 * (min(window.high, 9.0) - window.low)
            for a, b in (
                (inside, inside * (1 + 1e-9)),
                (0.5 * window.low, 2.0 * window.low),
                (window.low * 0.999, 9.0),
            ):
                proof = prove_no_attractor(lam, l, a, b)
                assert not proof.proven and proof.document is None
                assert "attracts at mu" in proof.statement
        if theory.stability_interval(N + 1, lam, l).empty or window.empty or low >= high:
            continue
        gaps += 1
        proof = prove_no_attractor(lam, l, low * (1 + CLOSE), high * (1 - CLOSE))
        assert proof.proven, proof.statement
        assert check(proof.document) == proof.statement
    assert gaps > 0


def test_the_orbit_that_is_in_the_way_attracts():
    said = prove_no_attractor(0.9, 0.4, 0.3, 0.5).statement
    word, rest = said.split("the orbit ")[1].split(" attracts at mu = ")
    mu = float(rest.split(",")[0])
    (orbit,) = theory.word_orbits(word, 0.9, mu, 0.4)
    assert orbit.admissible and orbit.stable
    x = iterate(0.01, 5000 * len(word), 0.9, mu, 0.4)
    assert min(abs(orbit.points - x)) < 1e-9


@settings(deadline=None, max_examples=examples(200))
@given(
    lam=st.floats(0.05, 0.99), l=st.just(0.0) | st.floats(1e-3, 1.0), mu=st.floats(1e-3, 1.5), seed=st.integers(0, 99)
)
def test_the_weighted_length_is_stretched_as_the_proof_says(lam, l, mu, seed):
    # every step of the first return: c/(2 sqrt(s s')) >= (3 c^2/(4 C))^(3/4)
    x = float(np.random.default_rng(seed).uniform(0.0, mu))
    for _ in range(20):
        s, n = np.sqrt(x), 1
        x = mu - l - s
        while x < 0:
            x, n = lam * x + mu, n + 1
        c = lam ** (n - 1)
        C = theory.geometric_sum(n, lam) * mu - c * l
        assert c / (2 * (s * np.sqrt(x)) ** 0.5 + 1e-300) >= (3 * c * c / (4 * C)) ** 0.75 * (1 - 1e-6)
        assert n == 1 or mu < theory.mu_bc(n, lam, l) * (1 + 1e-12)


@pytest.mark.parametrize(("lam", "l"), [(0.9, 0.0), (0.8, 0.3), (0.6, 0.01)])
def test_orbits_between_windows_do_repel(lam, l):
    rng = np.random.default_rng(2)
    tried = 0
    for _ in range(400):
        mu = float(rng.uniform(0.02, 0.9) ** 2)
        if not prove_no_attractor(lam, l, mu, mu * (1 + 1e-9)).proven:
            continue
        x = float(iterate(0.01, 300, lam, mu, l))
        total = 0.0
        for _ in range(3000):
            total += np.log(abs(slope(x, lam)))
            x = lam * x + mu if x < 0 else mu - l - np.sqrt(x)
        assert total > 0.0
        tried += 1
        if tried == 15:
            break
    assert tried > 3


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ((1.2, 0.0, 0.1, 0.2), "lam = 1.2; allowed is 0 < lam < 1"),
        ((0.9, -0.1, 0.1, 0.2), "l = -0.1; allowed is l >= 0"),
        ((0.9, 0.0, 0.2, 0.1), "allowed is 0 <= low < high"),
        ((0.9, 0.0, -0.2, 0.1), "attracts"),
        ((0.9, 0.1, 0.0, 0.1), "give a low > 0"),
        ((0.6, 0.0, 0.0, 0.1), "give a low > 0"),
        ((0.9, 0.0, 0.1, float("nan")), "high = nan"),
    ],
)
def test_error_texts(args, said):
    with pytest.raises(InputError, match=said):
        prove_no_attractor(*args)


def test_too_close_to_0_says_so():
    proof = prove_no_attractor(0.9999, 0.0, 1e-300, 1e-299)
    assert proof.proven or "begin further from 0" in proof.statement
