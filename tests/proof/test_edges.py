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
