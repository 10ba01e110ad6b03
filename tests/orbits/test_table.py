"""Tables of orbits and windows."""

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.periodic import periodic_orbits
from grazing.orbits.table import orbit_table, window_table


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
