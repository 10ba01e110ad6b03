"""All branches of a word or a period: each followed once, with windows and loci, or a message that says what to try."""

import re

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.compare.word_branches import branches, loci_of
from grazing.orbits.branch import Branch


@pytest.mark.parametrize(("alpha", "V", "bounds"), [(3.0, 0.4, (0.08, 0.14)), (2.0, 0.3, (0.15, 0.18))])
def test_windows_are_those_of_closed_forms(alpha, V, bounds):
    model = gz.pinball(alpha=alpha, V=V, d=0.5 * sum(bounds))
    table = branches(gz.stroboscopic_map(model), "d", bounds, word="001", starts=200)
    expected = gz.windows(model, "d", N=3, span=bounds)
    stable = table.window_word.values == "001"
    for side in ("low", "high"):
        found = np.sort(table[f"window_{side}"].values[stable])
        np.testing.assert_allclose(found, np.sort(expected[side].values), rtol=0, atol=1e-10)
    assert table.attrs["parameter"] == "d" and len(table.attrs["values"]) == 9


def test_an_orbit_found_at_many_values_is_one_branch():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    one = branches(P, "d", (0.1, 0.13), word="001", at=[0.11], starts=200)
    many = branches(P, "d", (0.1, 0.13), word="001", at=[0.105, 0.11, 0.115, 0.12], starts=200)
    assert one.piece.values.max() == many.piece.values.max()
    np.testing.assert_allclose(np.sort(one.special_value), np.sort(many.special_value), atol=1e-9)


def test_a_branch_is_solved_once_at_a_value_however_many_orbits_are_found_there(monkeypatch):
    """Each orbit asked each branch again: of hundreds of orbits beside hundreds of branches that took minutes."""
    asked, at = [], Branch.at
    monkeypatch.setattr(Branch, "at", lambda self, value: asked.append((id(self), value)) or at(self, value))
    branches(gz.gap_map(lam=0.8, mu=0.5, l=1.0), "mu", (0.05, 0.9), period=[1, 2, 3], at=[0.3, 0.5], limit=5)
    assert len(asked) == len({*asked}) > 2


def test_every_word_of_a_period_is_followed():
    G = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    table = branches(G, "mu", (0.05, 0.9), period=[1, 2, 3])
    assert {"LR", "LLR"} <= set(table.word.values.tolist())


def test_loci_are_taken_apart_as_they_were():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    table = branches(P, "d", (0.09, 0.13), word="001", at=[0.11], locus={"V": (0.3, 0.5)}, starts=200)
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    branch = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))
    special = {one.type: one for one in branch.special if one.admissible}
    for part in loci_of(table):
        expected = gz.locus(special[part.attrs["type"]], ("d", "V"), ((0.09, 0.13), (0.3, 0.5))).dataset
        assert part.attrs["word"] == expected.attrs["word"]
        for name in ("d", "V"):  # both begin and end at the same points, on the same curve
            found = np.sort(part[name].values[[0, -1]])
            np.testing.assert_allclose(found, np.sort(expected[name].values[[0, -1]]), atol=1e-9)
    assert loci_of(xr.Dataset()) == []


def test_nothing_found_says_what_was_tried():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    with pytest.raises(gz.InputError, match=r"no orbit of word 001 was found at d = 0\.021, .* more starts"):
        branches(P, "d", (0.02, 0.03), word="001", starts=50)
    table = branches(P, "d", (0.02, 0.03), word="001", starts=50, virtual=True)
    assert not table.admissible.values.any() and table.sizes["window"] == 0


def test_all_branches_share_a_limit_of_points_and_values_are_counted():
    """An orbit was followed anew from each value where ``limit`` cut its branch: of thousands that took minutes."""
    G, bounds, counted = gz.gap_map(lam=0.8, mu=0.5, l=1.0), (0.05, 0.9), []
    every = branches(
        G, "mu", bounds, period=[1, 2, 3], limit=5, virtual=True, progress=lambda *done: counted.append(done)
    )
    assert counted[0] == (0, 9) and counted[-1] == (9, 9) and counted == sorted(counted)
    assert every.sizes["point"] > 60 and "a larger limit (points)" not in every.attrs["unfinished"]
    few = branches(G, "mu", bounds, period=[1, 2, 3], limit=5, virtual=True, points=30)
    assert few.sizes["point"] < 50
    assert re.search(r"30 points in all was reached at mu = 0\.\d+; a larger limit \(points\)", few.attrs["unfinished"])
