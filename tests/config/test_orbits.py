"""Tables of orbits and windows, and proofs of the edges of windows."""

import numpy as np
import pytest

import grazing as gz
from grazing.config.orbits import edge_proofs, orbit_table, window_table
from grazing.orbits.periodic import periodic_orbits


def test_a_table_of_orbits_holds_them_all():
    P = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    found = periodic_orbits(P, range(1, 4), virtual=True)
    table = orbit_table(found)
    assert table.attrs["statement"] == found.statement
    for i, orbit in enumerate(found):
        row = table.isel(orbit=i)
        assert (str(row.word.values), int(row.period), bool(row.stable)) == (orbit.word, orbit.period, orbit.stable)
        assert np.array_equal(row.x.values[: orbit.period], orbit.points[:, 0])
        assert np.isnan(row.x.values[orbit.period :]).all()
        assert complex(row.multiplier_real[0], row.multiplier_imag[0]) == orbit.multipliers[0]


def test_an_empty_table_can_be_kept(tmp_path):
    table = orbit_table(periodic_orbits(gz.gap_map(lam=0.8, mu=-0.5, l=1.0), 4))
    assert table.sizes["orbit"] == 0
    gz.save(table, tmp_path / "a.nc")
    assert gz.load(tmp_path / "a.nc").sizes["orbit"] == 0


@pytest.mark.parametrize("law", [gz.newton(0.7), gz.active(0.6, 0.3)])
def test_derivatives_lie_beside_their_windows(law):
    model = gz.pinball(alpha=2.5).replace()
    model = gz.Oscillator(model.alpha, model.k, model.forcing, law, offset_name="d")
    table = window_table(model, "d", [2, 3], sensitivity=True)
    expected = gz.sensitivity(model, "d", N=[2, 3])
    assert table.moved.values.tolist() == expected.parameter.values.tolist()
    assert np.array_equal(table.derivative.values, expected.derivative.values, equal_nan=True)
    assert np.array_equal(table.low.values, gz.windows(model, "d", N=[2, 3]).low.values)


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
