"""Proofs about orbits and edges of the gap map hold what closed forms and orbits in double precision say."""

import json
from dataclasses import replace

import numpy as np
import pytest
from flint import arb, ctx

import grazing as gz
from grazing import theory
from grazing.orbits.gap_orbits import gap_orbits
from grazing.outcome import InputError
from grazing.proof.gap import certify_gap_edge, certify_gap_orbit
from grazing_checker import check
from grazing_checker.envelope import opened
from grazing_checker.reading import exact

WINDOWS = [(N, lam, l) for N in (1, 2, 3, 5, 8) for lam, l in ((0.5, 0.2), (0.9, 0.4), (0.34, 0.21))]


@pytest.mark.parametrize(("N", "lam", "l"), WINDOWS)
def test_maximal_orbits_and_their_doubles_are_proven(N, lam, l):
    word = "L" * (N - 1) + "R"
    pd, bc = theory.stability_interval(N, lam, l)
    for mu in (pd + 0.3 * (min(bc, pd + 2.0) - pd), 0.5 * (theory.mu_gr(N, lam, l) + pd)):
        proof = certify_gap_orbit(word, lam, mu, l)
        assert proof.proven and proof.document["data"]["claims"]["stable"] == (mu > pd)
        low, high = map(float, proof.document["data"]["claims"]["multiplier"])
        assert low <= theory.multiplier(N, lam, mu, l) * (1 + 1e-12) or low <= theory.multiplier(N, lam, mu, l) + 1e-12
        assert low - 1e-11 <= theory.multiplier(N, lam, mu, l) <= high + 1e-11 and high - low < 1e-8 * (1 + abs(low))
        assert check(json.loads(json.dumps(proof.document))) == proof.statement
        assert opened(proof.document)["kind"] == "gap map orbit"
    low, high = theory.doubled_interval(N, lam, l)
    proof = certify_gap_orbit(word * 2, lam, 0.5 * (low + high), l)
    assert proof.proven and proof.document["data"]["claims"]["stable"] is False
    assert f"least period {2 * N}" in proof.statement and "so that it is unstable" in proof.statement


@pytest.mark.parametrize(("N", "lam", "l"), WINDOWS)
def test_edges_are_enclosed_with_their_closed_forms(N, lam, l):
    word = "L" * (N - 1) + "R"
    closed = {"gr": theory.mu_gr(N, lam, l), "pd": theory.mu_pd(N, lam, l), "bc": theory.mu_bc(N, lam, l)}
    for edge, value in closed.items():
        if np.isinf(value):
            assert certify_gap_edge(word, edge, lam, l) == ()
            continue
        (proof,) = certify_gap_edge(word, edge, lam, l)
        assert proof.proven
        low, high = proof.value
        assert low < value < high and high - low < 1e-12
        assert check(proof.document) == proof.statement


def test_the_middle_of_an_enclosure_has_many_digits():
    before, ctx.prec = ctx.prec, 200
    try:
        a, gap = arb(0.9), arb(0.4)  # mu_pd(3) by its closed form in balls
        closed = (a**2 * gap + 3 * a**4 / 4) / (1 + a + a**2)
        (proof,) = certify_gap_edge("LLR", "pd", 0.9, 0.4)
        assert abs(exact(proof.document["data"]["centre"][-1]) - closed) < arb(10) ** -40
    finally:
        ctx.prec = before


@pytest.mark.parametrize(
    ("word", "lam", "l", "kinds"),
    [("LLRR", 0.5, -0.6, "gr bc lp"), ("LRRR", 0.297, -0.254, "bc pd"), ("LLRRLRR", 0.342, -0.668, "bc lp")],
)
def test_edges_of_words_with_several_right_letters(word, lam, l, kinds):
    edges = theory.word_edges(word, lam, l)
    assert {kind for kind in edges._fields if getattr(edges, kind)} >= set(kinds.split())
    for kind in kinds.split():
        proofs = certify_gap_edge(word, kind, lam, l)
        assert len(proofs) == len(getattr(edges, kind))
        for proof, value in zip(proofs, getattr(edges, kind), strict=True):
            assert proof.proven, proof.statement
            low, high = proof.value
            assert low < value < high


@pytest.mark.parametrize(
    ("lam", "mu", "l"), [(0.9, 0.1, 0.05), (0.342, 0.023, -0.668), (-0.4, 0.6, 0.2), (1.2, 0.1, 0.3)]
)
def test_every_admissible_orbit_of_a_map_is_proven_and_no_virtual_one(lam, mu, l):
    G = gz.gap_map(lam=lam, mu=mu, l=l)
    proven = 0
    for period in range(1, 7):
        for orbit in gap_orbits(G, period):
            proof = certify_gap_orbit(orbit)
            if not orbit.admissible or orbit.word == "L":
                assert not proof.proven and proof.document is None and proof.statement.startswith("Nothing is proven")
                continue
            assert proof.proven, proof.statement
            proven += 1
            assert proof.document["data"]["claims"]["stable"] == orbit.stable
            low, high = map(float, proof.document["data"]["claims"]["multiplier"])
            assert low <= orbit.multipliers[0].real * (1 + 1e-9 * np.sign(high)) + 1e-9 and high >= low
            check(proof.document)
    assert proven > 0


def test_a_saved_certificate_is_checked_from_its_file(tmp_path):
    proof = certify_gap_orbit("LLR", 0.8, 0.5, 1.0)
    path = proof.save(tmp_path / "orbit.json")
    assert check(json.loads(path.read_text())) == proof.statement
    assert gz.check_certificate(path) == proof.statement
    assert proof.value is None


def test_what_cannot_be_proven_says_why():
    assert "has no admissible orbit" in certify_gap_orbit("LLR", 0.8, 0.9, 1.0).statement
    assert "slope is infinite" in certify_gap_orbit("R", 0.5, 0.25, 0.25).statement
    exactly = certify_gap_orbit("R", 0.5, 0.75, 0.0)  # the multiplier is -1, all numbers are exact
    assert not exactly.proven and "cannot be told from 1 in modulus" in exactly.statement
    assert "there is nothing to enclose" in certify_gap_orbit("L", 0.5, -0.1, 0.1).statement
    assert "1 to 1000 letters" in certify_gap_edge("L" * 1000 + "R", "gr", 0.5, 0.1)[0].statement


def of_another_map():
    logistic = gz.Map(lambda state, p: (p.a * state[0] * (1.0 - state[0]),), {"a": 3.2}, ("x",), ((0.0, 1.0),))
    return replace(gap_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), 3)[0], map=logistic)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: certify_gap_orbit("LLR", 0.8, 0.5), "a word alone names no orbit; give lam, mu and l"),
        (lambda: certify_gap_orbit("LXR", 0.8, 0.5, 0.1), "word = 'LXR'"),
        (lambda: certify_gap_orbit(of_another_map()), "give one of a gap map"),
        (lambda: certify_gap_edge("LLR", "ns", 0.8, 0.5), "edge = 'ns'; allowed are gr, bc, pd, lp"),
        (lambda: certify_gap_edge("LRLR", "pd", 0.8, 0.5), "edges are proven for primitive words with an R"),
        (lambda: certify_gap_edge("LR", "pd", 1.8, 0.5), "no span of mu"),
        (lambda: certify_gap_orbit("LLR", 0.8, 0.9, 1.0).save("x"), "there is nothing to save: Nothing is proven"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(InputError, match=said):
        call()
