"""Proofs of the edges of windows."""

import numpy as np
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


def test_two_orbits_that_end_at_one_value_are_proven_each():
    """The true period of the force is T/2: each orbit has a copy T/2 later, in a window of the same ends."""
    half = gz.Forcing(omega=1.1, offset=0.12, cos=(0.0, 1.0))
    model = gz.Oscillator(alpha=3.0, k=1.0, forcing=half, reset=gz.active(r=0.8, V=0.4))
    table = gz.windows(model, "offset", 1, (-0.9, 0.9), samples=200)
    assert table.sizes["window"] == 2
    times = {}
    for w, side, proof in edge_proofs(model, table):
        phase = 1.1 * float(proof.claims["box"][0][0]) % (2 * np.pi)
        assert phase == pytest.approx(float(table[f"{side}_phase"].values[w]), abs=1e-7)
        times[w, side] = float(proof.claims["box"][0][0])
    for side in ("low", "high"):
        assert abs(times[0, side] - times[1, side]) == pytest.approx(np.pi / 1.1)


def test_a_proof_of_another_value_or_orbit_is_none_of_the_edge():
    model = gz.pinball(V=0.4)
    table = gz.windows(model, "d", 3, (0.09, 0.13), samples=100)
    beside = table.assign(low=table.low + 1e-11, high=table.high - 1e-11)  # a part of 4e-10 of the window's width
    said = [proof for _w, _side, proof in edge_proofs(model, beside)]
    assert len(said) == 2 and all(str(one).startswith("the proof is of another value") for one in said)
    turned = table.assign(low_phase=table.low_phase + 0.01, high_phase=table.high_phase - 0.01)
    said = [proof for _w, _side, proof in edge_proofs(model, turned)]
    assert len(said) == 2 and all(str(one).startswith("the proof is of another orbit") for one in said)


def test_where_a_double_is_born_the_multiplier_that_is_proven_is_that_of_the_orbit_it_doubles():
    """Its own is +1 there: another pd of the double, at 0.7907 or 0.9259, was enclosed and refused."""
    walls = gz.wall(-0.5, gz.newton(0.87)), gz.wall(0.5, gz.newton(0.8))
    model = gz.Oscillator(alpha=0.1, k=0.5, forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=walls)
    table = gz.windows(model, "B.r", 2, (0.86, 0.88), samples=2, words="ABAB")
    born = [
        (w, side) for w in range(table.sizes["window"]) for side in ("low", "high") if table[f"{side}_type"][w] == "pd"
    ]
    assert len(born) == 2
    proofs = {(w, side): proof for w, side, proof in edge_proofs(model, table)}
    for w, side in born:
        low, high = proofs[w, side].value
        assert low <= float(table[side].values[w]) <= high and high - low < 1e-12
        assert proofs[w, side].document["data"]["impacts"] == ["A", "B"]
    assert "of a double that is born there" in table.low_type.attrs["meaning"]
