"""Each cell has the colour of its class; the graze is drawn where it is."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from grazing import plot
from grazing.outcome import InputError
from grazing.plot.style import ENDED
from grazing.plot.validity import CLASSES, OVERLAP, validity
from tests.plot import results


def made_up(nx=12, ny=10, graze="V"):
    d, V = np.linspace(0.0, 1.1, nx), np.linspace(0.0, 0.9, ny)
    codes = (np.arange(nx)[:, None] + np.arange(ny)) % 5
    overlap = np.where(codes == 4, np.nan, np.linspace(0.0, 1.0, nx)[:, None] * np.ones(ny))
    along, other = (V, d) if graze == "V" else (d, V)
    result = xr.Dataset(
        {
            "agreement": (("d", "V"), codes.astype(np.int8)),
            "overlap": (("d", "V"), overlap),
            "graze": (graze, other.mean() + 0.1 * along),
        },
        {"d": d, "V": V},
        results.ATTRS,
    )
    result["d"].attrs["symbol"] = "d"
    return result


def colours(drawn):
    """The colour of each cell, first index along x."""
    return np.swapaxes(np.asarray(drawn["image"].get_array()), 0, 1)


def test_cells_have_the_colours_of_their_classes():
    result = made_up()
    drawn = validity(result)
    cells = colours(drawn)
    for code, (colour, _name) in CLASSES.items():
        own = cells[result.agreement.values == code]
        assert {to_hex(one / 255.0) for one in own} == {to_hex(colour)}
    texts = [text.get_text() for text in drawn["legend"].get_texts()]
    assert texts == [*(name for _colour, name in CLASSES.values()), "graze"]
    ax = drawn["image"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$d$", "V")
    assert drawn["provenance"]["title"] == "made up"


def test_only_classes_that_occur_are_named():
    result = made_up()
    same = result.assign(agreement=result.agreement * 0)
    assert [t.get_text() for t in validity(same)["legend"].get_texts()] == ["same words", "graze"]
    assert validity(same, legend=False)["legend"] is None


def test_overlap_has_a_bar():
    result = made_up()
    drawn = validity(result, by="overlap")
    cells = colours(drawn)
    outside = np.isnan(result.overlap.values)
    assert {to_hex(one / 255.0) for one in cells[outside]} == {ENDED}
    assert to_hex(cells[0, 0] / 255.0) == OVERLAP[0] and to_hex(cells[-1, 0] / 255.0) == OVERLAP[-1]
    assert drawn["bar"] is not None
    assert validity(result, by="overlap", legend=False)["bar"] is None


@pytest.mark.parametrize("along", ["d", "V"])
def test_the_graze_is_where_it_is(along):
    result = made_up(graze=along)
    line = validity(result)["graze"]
    x, y = line.get_xdata(), line.get_ydata()
    assert (y if along == "d" else x) == pytest.approx(result.graze.values)
    own = x if along == "d" else y
    assert own == pytest.approx(result[along].values)
    assert validity(result.assign(graze=result.graze + 9.0))["graze"] is None


def test_curves_and_single_values():
    drawn = validity(made_up(), curves={"pd": ([0.1, 0.9], [0.2, 0.8])})
    assert list(drawn["curves"]) == ["pd"]
    one = made_up().isel(V=[3])
    assert validity(one)["image"].axes.get_yticks().tolist() == pytest.approx([0.3])


@pytest.mark.parametrize("by", ["agreement", "overlap"])
def test_it_can_be_written(by):
    assert plot.rendered(validity(made_up(), by=by), "png")


def test_what_is_refused():
    with pytest.raises(InputError, match="by is 'word'; allowed are 'agreement', 'overlap'"):
        validity(made_up(), by="word")
    with pytest.raises(InputError, match=r"finds no agreement .* grazing\.validity returns"):
        validity(results.chart())
    with pytest.raises(InputError, match="cannot draw a list"):
        validity([])
