"""Figures of launches: each colour says what the result says."""

import numpy as np
import pytest
from matplotlib.colors import LogNorm, to_rgba

import grazing as gz
from tests.maps.test_collisions import pinball

POINT = 3.0, 8.0


@pytest.fixture(scope="module")
def found():
    return gz.launches(pinball(), POINT, np.linspace(-3.0, 3.0, 12), np.linspace(0.2, 2.0, 9), hits=60)


def test_every_launch_has_the_colour_of_its_way_out(found):
    drawn = gz.plot.launches(found)
    cells = drawn["image"].get_array()
    at = {name: np.round(255 * np.array(to_rgba(colour))) for name, colour in drawn["colours"].items()}
    assert set(at) == set(np.unique(found.exit.values)) and len({*map(tuple, at.values())}) == len(at)
    rows = np.asarray(cells)
    wide, high = rows.shape[1] // 12, rows.shape[0] // 9
    seen = rows[high // 2 :: high, wide // 2 :: wide]
    for i, j in np.ndindex(12, 9):
        assert seen[j, i].tolist() == at[found.exit.values[i, j]].tolist()
    said = dict(text.get_text().split(": ") for text in drawn["legend"].get_texts())
    assert set(said) == {name or "still there" for name in at}
    assert said["left_drain"] == f"{100 * (found.exit.values == 'left_drain').mean():.0f} %"


def test_lifetimes_are_on_a_logarithmic_scale_and_line_up_for_one_angle(found):
    by = gz.plot.launches(found, by="time")
    values = np.ma.filled(by["image"].get_array(), np.nan)
    left = found.time.values[(found.exit.values != "") & np.isfinite(found.time.values)]
    assert (
        np.nanmax(values) == pytest.approx(left.max())
        and isinstance(by["image"].norm, LogNorm)
        and by["bar"] is not None
    )
    line = gz.plot.launches(found.isel(angle=[4]), by="hits")
    points = [tuple(xy) for one in line["points"] for xy in one.get_xydata().tolist()]
    assert sorted(points) == sorted(zip(found.speed.values.tolist(), found.hits.values[4].tolist(), strict=True))


def test_no_impact_is_told_from_one_and_ways_without_room_are_summed_up(found):
    few = found.isel(angle=slice(4), speed=slice(4))
    few = few.assign(
        hits=few.hits.copy(data=np.arange(16).reshape(4, 4)), exit=few.exit.copy(data=np.full((4, 4), "a"))
    )
    few.exit[3, 3] = ""
    drawn = gz.plot.launches(few, by="hits")
    cells = np.ma.asarray(drawn["image"].get_array())
    assert cells[0, 0] == 0 and cells.mask[-1, -1] and drawn["bar"].ax.get_yticks()[:2].tolist() == [0.0, 1.0]
    shades = drawn["image"].to_rgba(np.arange(15.0))
    assert len({*map(tuple, shades)}) == 15
    many = few.assign(exit=few.exit.copy(data=np.array([f"out{k}" for k in range(16)]).reshape(4, 4)))
    said = [text.get_text() for text in gz.plot.launches(many)["legend"].get_texts()]
    assert len(said) == 14 and said[-1].startswith("3 more: 19 %")


def test_another_result_is_refused(found):
    with pytest.raises(gz.InputError, match=r"plot\.launches finds no exit"):
        gz.plot.launches(gz.trajectory(gz.pinball(), (0.1, 0.0), until=3.0))
    with pytest.raises(gz.InputError, match="by is 'way'; allowed are"):
        gz.plot.launches(found, by="way")
