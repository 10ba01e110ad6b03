"""Areas add up to the shares; changes are marked; lifetimes are lines of the same colours."""

import numpy as np
import pytest

from grazing import plot
from grazing.outcome import InputError
from grazing.plot.style import CHAOS, PERIODS
from tests.plot import results


def names(legend):
    return [text.get_text() for text in legend.get_texts()]


def area(shape):
    """The area of a collection of polygons."""
    total = 0.0
    for path in shape.get_paths():
        x, y = path.vertices[:, 0], path.vertices[:, 1]
        total += 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return total


def test_areas_are_the_shares():
    result = results.coexistence()
    drawn = plot.coexistence(result)
    width = float(np.diff(result["mu"].values[:2])[0])
    for k, shape in drawn["areas"].items():
        assert area(shape) == pytest.approx(width * float(result["share"][:, k].sum()), rel=1e-9)
    ax = drawn["areas"][0].axes
    assert ax.get_ylim() == (0.0, 1.0)
    assert ax.get_xlim() == pytest.approx((-width / 2, 1 + width / 2))
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\mu$", "share of the starts")


def test_periods_have_their_colours_and_the_rest_is_on_top():
    drawn = plot.coexistence(results.coexistence())
    assert list(drawn["areas"]) == [0, 1, 3, 4, 2, 5, 6]  # by period, then aperiodic, then undecided
    from matplotlib.colors import to_hex

    assert to_hex(drawn["areas"][0].get_facecolor()[0]) == PERIODS[0]
    assert to_hex(drawn["areas"][3].get_facecolor()[0]) == PERIODS[2]
    assert to_hex(drawn["areas"][5].get_facecolor()[0]) == CHAOS
    assert names(drawn["legend"])[:4] == [
        "undecided",
        "aperiodic",
        "01, period 4",
        r"$\mathrm{L}^{6}\mathrm{R}$, period 3",
    ]


def test_names_stand_inside_their_areas():
    result = results.coexistence()
    drawn = plot.coexistence(result)
    share = result["share"].values
    stack = list(drawn["areas"])
    assert {0, 3} <= set(drawn["names"]) <= {0, 3, 4}  # 01 is the word of two attractors: it would name none
    for k, text in drawn["names"].items():
        x, y = text.get_position()
        i = int(np.argmin(np.abs(result["mu"].values - x)))
        below = share[i, stack[: stack.index(k)]].sum()
        assert below < y < below + share[i, k]


def test_changes_are_marked_halfway_and_relabellings_are_hollow():
    result = results.coexistence()
    drawn = plot.coexistence(result)["changes"]
    assert list(drawn) == ["appears", "disappears", "doubles", "relabelled", "merges"]
    middle = 0.5 * (result["before"] + result["after"]).values
    kinds = result["kind"].values
    for kind, line in drawn.items():
        assert line.get_xdata().tolist() == middle[kinds == kind].tolist()
    assert drawn["relabelled"].get_markerfacecolor() == "white"
    assert drawn["doubles"].get_markerfacecolor() != "white"
    assert plot.coexistence(result, changes=False)["changes"] == {}
    assert plot.coexistence(result.drop_vars("kind"))["changes"] == {}
    assert plot.coexistence(result.isel(change=slice(0)))["changes"] == {}


def test_changes_of_several_kinds_at_one_place_are_above_each_other():
    result = results.coexistence()
    result["before"][:], result["after"][:] = result["before"][0], result["after"][0]
    drawn = plot.coexistence(result)["changes"]
    heights = [set(line.get_ydata()) for line in drawn.values()]
    assert all(len(one) == 1 for one in heights) and len(set.union(*heights)) == len(drawn) == 5
    apart = np.diff([min(one) for one in heights]).min()
    assert apart > max(line.get_markersize() for line in drawn.values())


def test_lifetimes_are_lines():
    result = results.coexistence()
    drawn = plot.coexistence(result, of="lifetime")
    assert "areas" not in drawn
    for k, line in drawn["lines"].items():
        assert np.array_equal(line.get_ydata(), result["lifetime"].values[:, k], equal_nan=True)
    assert drawn["lines"][0].axes.get_yscale() == "log"
    assert drawn["lines"][0].get_color() == PERIODS[0]
    both = plot.coexistence(result.assign(lifetime=0 * result["share"]), of="lifetime")
    plot.rendered(both, "png")  # nothing positive on a logarithmic axis


def test_a_lifetime_of_nothing_is_drawn_where_it_is():
    result = results.coexistence()
    result.lifetime[3, 0] = 0.0
    line = plot.coexistence(result, of="lifetime")["lines"][0]
    low, high = line.axes.get_ylim()
    assert line.get_ydata()[3] == 0.0 and low < 0.0 < high and 0.0 in line.axes.get_yticks()


def test_a_part_of_a_result_marks_its_own_changes():
    result = results.coexistence().isel(mu=slice(20, 60))
    drawn = plot.coexistence(result)["changes"]
    low, high = result.mu.values[[0, -1]]
    middle = 0.5 * (result.before + result.after).values
    there = middle[(middle > low) & (middle < high)]
    assert sorted(x for line in drawn.values() for x in line.get_xdata()) == sorted(there)
    assert 0 < there.size < middle.size


def test_two_panels():
    fig, axes = plot.panels(174, 130, 2, 1, sharex=True)
    for ax, of in zip(axes, ("share", "lifetime"), strict=True):
        assert plot.coexistence(results.coexistence(), ax, of=of)["figure"] is fig


def test_many_attractors_and_one_value():
    many = results.coexistence(np.linspace(0, 1, 50), tuple(range(1, 60)), ["L" * (k - 1) + "R" for k in range(1, 60)])
    found = names(plot.coexistence(many)["legend"])
    assert any(name.endswith(" more") for name in found)
    single = plot.coexistence(results.coexistence(np.array([0.3])))
    assert area(single["areas"][0]) == pytest.approx(0.03 * 0.75)
    assert single["areas"][0].axes.get_xticks().tolist() == [0.3]
    assert plot.coexistence(many, legend=False)["legend"] is None


def test_what_is_refused():
    with pytest.raises(InputError, match="of is 'age'; allowed are 'share', 'lifetime'"):
        plot.coexistence(results.coexistence(), of="age")
    with pytest.raises(InputError, match=r"finds no lifetime in .*lifetime on \(<parameter>, attractor\)"):
        plot.coexistence(results.coexistence().drop_vars("lifetime"), of="lifetime")
    with pytest.raises(InputError, match=r"finds share on \(mu, l, rank\)"):
        plot.coexistence(results.chart())
