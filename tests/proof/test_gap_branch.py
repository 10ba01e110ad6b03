"""Edges of the gap map that belong to the orbit that is given, and not to another one of its word."""

import pytest

import grazing as gz
from grazing.orbits.gap_orbits import gap_orbits
from grazing.proof.enclose import enclose
from grazing.proof.gap_branch import nearest_edge


def orbits(lam, mu, l, period, word):
    return [one for one in gap_orbits(gz.gap_map(lam=lam, mu=mu, l=l), period) if one.word == word]


def test_of_two_orbits_of_a_word_each_has_its_own_edges():
    """At this mu LLRR has two admissible orbits, which meet in a fold below; above, each ends in its own way."""
    both = [one for one in orbits(0.5, 0.0245580187874896, -0.6, 4, "LLRR") if one.admissible]
    (stable,), (unstable,) = ([one for one in both if one.stable is kind] for kind in (True, False))
    for one in (stable, unstable):
        low, high = enclose(one, "lp", "mu").value
        assert low < 0.02321914945430513 < high
    assert enclose(stable, "bcb", "mu").value[0] == pytest.approx(0.02682424716271)
    assert enclose(unstable, "gr", "mu").value[0] == pytest.approx(0.02744488371942)
    for one, kind in ((stable, "gr"), (unstable, "bcb")):
        proof = enclose(one, kind, "mu")
        assert not proof.proven and f"no {kind} of LLRR is joined to this orbit" in proof.statement


def test_an_orbit_that_goes_round_its_word_twice_is_given_no_edge_of_the_word():
    (doubled,) = orbits(0.9, 0.19, 0.0, 6, "LLR")
    assert doubled.period == 6
    for kind in ("pd", "bcb", "gr", "lp"):
        with pytest.raises(gz.InputError, match="goes round LLR 2 times"):
            enclose(doubled, kind, "mu")


def test_an_edge_that_is_not_proven_is_not_replaced_by_another_one(monkeypatch):
    from grazing.proof import gap_branch

    (orbit,) = orbits(0.9, 0.17, 0.0, 3, "LLR")
    proofs = gap_branch.certify_gap_edge("LLR", "pd", 0.9, 0.0)
    failed = gap_branch.GapProof(False, "Nothing is proven: for a test.", None)
    monkeypatch.setattr(gap_branch, "certify_gap_edge", lambda *_args: (failed,))
    assert nearest_edge(orbit, "pd") is failed
    monkeypatch.setattr(gap_branch, "certify_gap_edge", lambda *_args: (failed, *proofs))
    assert nearest_edge(orbit, "pd") is proofs[0]


@pytest.mark.parametrize(
    ("lam", "mu", "l", "word", "edge", "value"),
    [
        (0.7815436046067354, 0.04183235342815648, 0.0, "LR", "pd", 0.2571409440901),
        (0.22039715277917754, 0.17230686987221108, 0.2807867235646755, "LR", "bc", 1.509337836092),
    ],
)
def test_the_only_orbit_of_a_word_leads_to_its_edge_whatever_is_rounded(lam, mu, l, word, edge, value):
    """The way began a rounding beside the orbit, which was then taken for another one, and led nowhere."""
    (orbit,) = orbits(lam, mu, l, len(word), word)
    assert nearest_edge(orbit, edge).value == pytest.approx((value, value), abs=1e-12)


def test_an_orbit_is_not_given_the_graze_of_one_that_is_born_in_a_fold_on_the_way():
    """It was the nearest there is on this side of the graze, where the one that grazes is not."""
    (stable,) = orbits(0.7358296625890101, 0.8757644698689329, -0.6936133796667541, 3, "LRR")
    assert stable.stable and nearest_edge(stable, "gr") is None
