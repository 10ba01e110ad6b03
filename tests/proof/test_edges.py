"""Proofs of the edges of windows."""

import pytest

import grazing as gz
from grazing.proof.edges import edge_proofs


@pytest.mark.parametrize(("alpha", "r", "V"), [(3.0, 0.8, 0.4), (2.0, 0.6, 0.5)])
def test_every_edge_is_proven_or_says_why_not(alpha, r, V):
    model = gz.pinball(alpha=alpha, r=r, V=V)
    table = gz.windows(model, "d", N=[2, 3], span=(-0.2, 0.12))
    assert table.sizes["window"]
    for w, side, proof in edge_proofs(model, table):
        kind, edge = str(table[f"{side}_type"].values[w]), float(table[side].values[w])
        if kind == "end":
            assert proof.startswith("a proof needs an edge of type")
            continue
        low, high = proof.value
        assert low <= edge <= high and high - low < 1e-12
        assert gz.check_certificate(proof.document) == proof.statement


def test_the_proof_of_a_graze_is_of_the_wall_that_the_window_names():
    walls = gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.6))
    model = gz.Oscillator(alpha=0.1, k=0.5, forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=walls)
    table = gz.windows(model, "omega", 1, (1.6, 1.9), samples=3, words="AB")
    grazes = [
        (w, side) for w in range(table.sizes["window"]) for side in ("low", "high") if table[f"{side}_type"][w] == "gr"
    ]
    assert grazes
    proofs = {(w, side): proof for w, side, proof in edge_proofs(model, table)}
    for w, side in grazes:
        named = str(table[f"{side}_wall"].values[w])
        assert proofs[w, side].document["data"]["dip"]["wall"] == named
        table[f"{side}_wall"].values[w] = {"A": "B", "B": "A"}[named]
    wrong = {(w, side): proof for w, side, proof in edge_proofs(model, table)}
    assert all("the proof is of a graze of the wall" in str(wrong[at]) for at in grazes)
