"""What a study found, against the result counted by hand and against closed forms."""

import json

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import studies
from grazing.catalogue.rows import told
from grazing.catalogue.words import words_of
from grazing.studies.cobweb import cobweb

G = gz.gap_map(lam=0.5, mu=0.07, l=0.1)
ROBUST = gz.gap_map(lam=0.8, mu=0.05, l=0.1)


def test_a_diagram_tells_where_each_word_was_reached_and_leaves_nothing_out():
    grid = np.linspace(0.1, 0.02, 30)  # the order of the values does not matter
    result = gz.orbit_diagram(G, "mu", grid, starts=20, keep=20)
    said = told(studies()["diagram"], result)
    assert sum(row["share"] for row in said["attractors"]) == pytest.approx(1.0, abs=1e-12)
    words = result["word"].values
    for row in said["attractors"]:
        here = sorted(x for x, texts in zip(grid, words, strict=True) if row["word"] in texts)
        assert len(here) == row["values"]
        inside = [x for x in grid if any(low <= x <= high for low, high in row["ranges"])]
        assert sorted(inside) == here


def test_a_range_that_is_interrupted_is_two():
    result = gz.orbit_diagram(G, "mu", [0.07, 0.2, 0.071, 0.3, 0.072], starts=5, keep=20)
    said = {row["word"]: row["ranges"] for row in told(studies()["diagram"], result)["attractors"]}
    assert said["LLR"] == [[0.07, 0.072]]
    result["word"].values[2], result["period"].values[2] = "other", 9
    said = {row["word"]: row["ranges"] for row in told(studies()["diagram"], result)["attractors"]}
    assert said["LLR"] == [[0.07, 0.07], [0.072, 0.072]] and said["other"] == [[0.071, 0.071]]


def test_shares_of_a_chart_are_those_of_its_cells():
    result = gz.chart(G, {"mu": np.linspace(0.02, 0.08, 9), "l": [0.1, 0.2, 0.3]}, starts=8)
    said = told(studies()["chart"], result)
    words, period = (result[name].values.reshape(27, 8) for name in ("word", "period"))
    assert sum(row["first"] for row in said["attractors"]) == pytest.approx(1.0, abs=1e-12)
    for row in said["attractors"]:
        cells = [
            row["word"] in one[p >= -2] for one, p in zip(words.reshape(27, 8), period.reshape(27, 8), strict=True)
        ]
        assert row["share"] == pytest.approx(np.mean(cells), abs=1e-12)
    assert said["several"] == pytest.approx(np.mean((period > -3).sum(axis=1) > 1), abs=1e-12)


def test_basins_of_two_attractors():
    result = gz.basins(gz.gap_map(lam=0.5, mu=0.043, l=0.1), {"x": np.linspace(-1, 1, 400)})
    said = told(studies()["basins"], result)
    assert [row["word"] for row in said["attractors"]] == ["LLR", "LLLR"]
    assert sum(row["share"] for row in said["attractors"]) == 1.0 and said["states"] == 400
    assert all(-1 < row["point"][0] < 1 for row in said["attractors"])


def test_exponents_are_those_of_the_closed_form_and_change_sign_where_they_do():
    said = told(studies()["lyapunov"], gz.lyapunov(G, starts=3))
    [row] = said["attractors"]
    want = np.log(abs(gz.theory.multiplier(3, 0.5, 0.07, 0.1))) / 3
    assert row["exponent"][0] == pytest.approx([want, want], rel=1e-12) and row["share"] == 1.0
    logistic = gz.Map(_logistic, params={"a": 3.9}, coordinates=("x",), box=((0.1, 0.9),))
    grid = np.array([4.0, 3.2, 3.83, 3.4])  # chaos, period 2, the window of period 3, period 2
    said = told(studies()["lyapunov"], gz.lyapunov(logistic, "a", grid, starts=3, transient=2000))
    assert said["positive"] == 1 and said["sign_changes"] == [[3.83, 4.0]]
    assert said["greatest"]["a"] == 4.0 and said["greatest"]["exponent"] == pytest.approx(np.log(2.0), abs=0.02)


def _logistic(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


def test_coexistence_tells_the_changes():
    result = gz.coexistence(G, "mu", [0.040, 0.043, 0.046], starts=50)
    said = told(studies()["coexistence"], result)
    assert {row["word"]: row["ranges"] for row in said["attractors"]} == {
        "LLLR": [[0.040, 0.043]], "LLR": [[0.043, 0.046]],
    }  # fmt: skip
    assert said["most_at_once"] == 2
    assert [(change["kind"], change["before"], change["after"]) for change in said["changes"]] == [
        ("appears", 0.040, 0.043), ("disappears", 0.043, 0.046),
    ]  # fmt: skip


def test_a_density_counts_every_point_once():
    result = gz.density(G, "mu", [0.05, 0.07], bins=40, range=(-0.05, 0.1), starts=20, keep=300)
    said = told(studies()["density"], result)
    assert said["counted"] + said["below"] + said["above"] == 2 * 20 * 300 and said["below"] > 0
    assert said["range"] == [-0.05, 0.1]


def test_a_trajectory_tells_impacts_and_rests():
    ball = gz.Oscillator(0.2, 1.0, gz.Forcing(1.0, offset=-0.9), gz.newton(0.5))
    result = gz.trajectory(ball, (0.1, 0.0), until=50.0)
    said = told(studies()["trajectory"], result)
    assert said["impacts"] == result.sizes["impact"] and said["chatter"]
    t = np.linspace(0.0, 50.0, 4001)
    u = np.interp(t, result.t, result.u)
    resting = np.zeros(len(t), bool)
    for begin, end in said["rests"]:
        resting |= (t > begin) & (t < end)
    assert np.all(u[resting] == 0.0)  # and it lies there only where the force presses it to the wall
    assert np.all(-0.9 + np.cos(t[resting]) < 1e-6) and resting.sum() > 500
    assert [row["t"] for row in said["first"]] == result.impact_time.values[:5].tolist()
    free = told(studies()["trajectory"], gz.trajectory(gz.pinball(d=0.5), (0.5, 0.0), until=5.0))
    assert free["impacts"] == 0 and free["rests"] == [] and "speeds" not in free


def test_letters_of_a_cobweb_are_those_of_its_points():
    result = cobweb(ROBUST, [0.1], steps=20)
    said = told(studies()["cobweb"], result)
    assert said["letters"] == "".join("L" if x <= 0 else "R" for x in result["x"].values[:-1])
    assert said["last"] == result["x"].values[-1] and said["ended"] is None


def test_a_cobweb_that_ended_in_the_transient():
    said = told(studies()["cobweb"], cobweb(gz.gap_map(lam=1e25, mu=0.2, l=0.1), [0.1], steps=5, transient=30))
    assert said["range"] is None and said["ended"] is not None
    assert words_of(studies()["cobweb"], said)[1] == f"ended at step {said['ended']}"


def test_a_graph_tells_where_the_letter_changes_and_how_far_the_reduction_is():
    P = gz.stroboscopic_map(gz.pinball(omega=2.1, t0=2.2, d=0.11, V=0.2))
    result = gz.graph(P, "u", np.linspace(0.01, 0.06, 101), fixed={"v": -0.23})
    said = told(studies()["graph"], result)
    letters, u = result["letter"].values, result["image_u"].values
    same = letters[0] == letters[1]
    assert said["agree"] == same.sum() and said["differ"]["u"] == np.abs(u[0] - u[1])[same].max()
    first = [row for row in said["letters"] if row["map"] == "stroboscopic map"]
    assert sum(row["states"] for row in first) == 101


def test_it_is_plain_and_keeps_the_note_about_the_box():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    result = gz.orbit_diagram(P, "d", np.linspace(0.05, 0.16, 6), starts=4)
    said = told(studies()["diagram"], result)
    assert said["note"] == result.attrs["grazing_outside"]
    assert json.loads(json.dumps(said)) == said
