"""Windows between walls: the impact pair in closed form, windows over one wall, and flights on either side."""

import math
from dataclasses import replace

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import windows as windows_study
from grazing.cli import main
from grazing.orbits import word_windows
from grazing.outcome import InputError

SHAKE = gz.Forcing(omega=1.0, sin=(1.0,), cos=())
#: Of the impact pair with r = 0.5: s = (1 - r)/((1 + r) pi).
S = 1.0 / (3.0 * math.pi)


def pair():
    box = gz.wall(-1.5, gz.newton(0.5), motion=SHAKE), gz.wall(1.5, gz.newton(0.5), motion=SHAKE)
    return gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=1.0, cos=()), walls=box)


def rattle(**more):
    walls = gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.6))
    return gz.Oscillator(**({"alpha": 0.1, "k": 0.5} | more), forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=walls)


def test_the_window_of_the_impact_pair_is_that_of_the_closed_form():
    # cos phi + 2 s sin phi = -s L has solutions up to s L = sqrt(1 + 4 s^2); symmetry breaks where
    # tan phi = -2(1 + r)/(pi(1 - r))
    found = gz.windows(pair(), "B.sigma", 1, (0.9, 9.5), samples=6)
    whole = found.isel(window=np.flatnonzero(found.symmetric.values))
    phi = math.pi + math.atan(-2.0 * 1.5 / (math.pi * 0.5))
    assert whole.word.values.tolist() == ["AB"]
    assert [str(whole.low_type[0].values), str(whole.high_type[0].values)] == ["bp", "lp"]
    assert float(whole.low[0]) == pytest.approx((math.pi**2 / 2 - 2) * math.sin(phi) - 1.5, rel=1e-9)
    assert float(whole.high[0]) == pytest.approx(math.sqrt(1.0 + 4.0 * S * S) / S - 1.5, rel=1e-9)
    broken = found.isel(window=np.flatnonzero(found.symmetric.values == 0))
    assert float(broken.high[-1]) == pytest.approx(float(whole.low[0]), rel=1e-9)  # one row for both images


def test_over_one_wall_they_are_the_windows_that_are_known():
    force = gz.Forcing(omega=2.2, offset=0.12, cos=(1.0,))
    model = gz.Oscillator(alpha=3.0, k=1.0, forcing=force, walls=[gz.wall(0.0, gz.active(0.8, 0.4))])
    turned = gz.Oscillator(
        alpha=3.0, k=1.0, forcing=gz.Forcing(omega=2.2, offset=-0.12, cos=(-1.0,)),
        walls=[gz.wall(0.0, gz.active(0.8, 0.4), "above", name="U")],
    )  # fmt: skip
    known = gz.windows(gz.pinball(V=0.4), "d", 3, (0.05, 0.2))
    found = gz.windows(model, "offset", 3, (0.05, 0.2), samples=4, words="A")
    above = gz.windows(turned, "offset", 3, (-0.2, -0.05), samples=4, words="U")
    for side, other in (("low", "high"), ("high", "low")):
        assert found[side].values == pytest.approx(known[side].values, abs=1e-11)
        assert found[f"{side}_type"].values.tolist() == known[f"{side}_type"].values.tolist()
        assert above[side].values == pytest.approx(-known[other].values, abs=1e-11)
    assert found.low_wall.values.tolist() == ["A"] and above.high_wall.values.tolist() == ["U"]
    assert found.piece.values.tolist() == ["whole"]


def test_inside_a_window_flights_follow_the_word_and_beyond_its_edges_none_does():
    found = gz.windows(rattle(), "B.r", 1, (0.35, 0.95), samples=6, words="AB,BAB")
    assert found.attrs["words"] == "AB,ABB" and found.sizes["window"] == 3
    for row in (found.isel(window=w) for w in range(3)):
        room = 1e-3
        for value, inside in ((float(row.low) + room, True), (float(row.high) - room, True),
                              (float(row.low) - room, False), (float(row.high) + room, False)):  # fmt: skip
            P = gz.stroboscopic_map(rattle()).replace(**{"B.r": value})
            stable = [one for one in gz.periodic_orbits(P, 1, starts=60) if one.stable]
            near = [one for one in stable if sorted(one.walls) == sorted(str(row.word.values))]
            those = (found.low < value) & (value < found.high) & (found.word == row.word)  # another one may go on there
            assert len(near) == int(those.sum())
            if inside:
                last = P.iterate(near[0].points[0] + 1e-7, 400)[-1]
                assert last == pytest.approx(near[0].points[0], abs=1e-6)
        kinds = {str(row.low_type.values), str(row.high_type.values)}
        assert kinds <= {"lp", "pd"}
        for side in ("low", "high"):  # a multiplier is +1 or -1 there
            P = gz.stroboscopic_map(rattle()).replace(**{"B.r": float(row[side])})
            want = 1.0 if str(row[f"{side}_type"].values) == "lp" else -1.0
            roots = [one.multipliers for one in gz.periodic_orbits(P, 1, starts=300, virtual=True)]
            assert min(np.abs(root - want).min() for root in roots) < 1e-4


def test_orbits_that_live_as_long_as_each_other_have_a_row_each():
    """Two orbits, half a period apart, are stable over all of the range: they were one row."""
    force, law = gz.Forcing(omega=2.0, cos=(0.01, 1.0)), gz.newton(0.6)
    one = gz.Oscillator(alpha=0.1, k=1.0, forcing=force, reset=law)
    walled = gz.Oscillator(alpha=0.1, k=1.0, forcing=force, walls=[gz.wall(0.0, law)])
    known, found = (gz.windows(m, "r", 1, (0.55, 0.65), samples=s) for m, s in ((one, 50), (walled, 3)))
    assert known.sizes["window"] == 2
    for side in ("low_phase", "high_phase"):
        assert sorted(found[side].values) == pytest.approx(sorted(known[side].values), abs=1e-9)


def test_mirror_images_are_told_from_other_orbits():
    """With s = 1/(3 pi) and L = 3 the impact pair has symmetric orbits; with L = 1.9 those whose symmetry is broken."""
    P = gz.stroboscopic_map(pair())
    for place, symmetric in ((1.5, True), (1.0, False)):
        found = gz.periodic_orbits(P.replace(**{"A.sigma": -place, "B.sigma": place}), 1, word="(BA)", starts=60)
        stable = [one for one in found if one.stable]
        assert len(stable) == (1 if symmetric else 2) and all(one.symmetric is symmetric for one in stable)
        assert word_windows.alike(stable[0], stable[-1])
        assert not any(word_windows.alike(stable[0], one) for one in found if not one.stable)


def test_all_mirror_images_are_images_where_what_moves_repeats_itself_in_a_period():
    """Moved three times a period, an orbit has an image at each odd sixth of it: which came first decided the rows."""
    P = gz.stroboscopic_map(pair()).replace(**{"A.sigma": -1.0, "B.sigma": 1.0})
    one, other = (each for each in gz.periodic_orbits(P, 1, word="(BA)", starts=60) if each.stable)
    often = gz.Forcing(omega=1.0 / 3.0, sin=(0.0, 0.0, 1.0), cos=())
    walls = [gz.wall(side, gz.newton(0.5), motion=often) for side in (-1.0, 1.0)]
    slow = gz.stroboscopic_map(gz.Oscillator(0.0, k=0.0, forcing=gz.Forcing(omega=1.0 / 3.0, cos=()), walls=walls))

    def subharmonic(orbit, third, faster):
        """As if one of six impacts were faster: in three turns from some third of a period on."""
        times = np.concatenate([orbit.times + 2.0 * math.pi * turn for turn in range(third, third + 3)])
        speeds = np.tile(orbit.outgoing, 3) * np.where(np.arange(6) == faster, 1.1, 1.0)
        return replace(orbit, map=slow, times=times, outgoing=speeds, walls=3 * orbit.walls)

    for third in (0, 1, 2):
        assert word_windows.alike(subharmonic(one, 0, 4), subharmonic(other, third, 5))  # that hits B at A's times
        assert word_windows.alike(subharmonic(one, 0, 4), subharmonic(one, third, 4)) is (third == 0)


def test_a_graze_names_its_wall():
    found = gz.windows(rattle(), "omega", 1, (1.6, 1.9), samples=3, words="AB")
    (at,) = np.flatnonzero(found.low_type.values == "gr")
    assert str(found.low_wall[at].values) == "A" and str(found.low_status[at].values) == "zero"


def test_a_stiffness_and_its_default_range(monkeypatch):
    flights = []
    fly = word_windows.simulated
    monkeypatch.setattr(word_windows, "simulated", lambda *call: flights.append(call) or fly(*call))
    inverted = gz.Oscillator(
        alpha=0.1, stiffness=-0.25, forcing=gz.Forcing(omega=2.0, cos=(1.5,)),
        walls=[gz.wall(x, gz.newton(0.8)) for x in (-1.0, 1.0)],
    )  # fmt: skip
    found = gz.windows(inverted, "A.r", (1, 2), samples=2, words="AB")
    assert len(flights) == 2  # once a value, for all periods
    assert found.attrs["span"] == [0.0, 1.0] and (found.low <= found.high).all()


def test_what_a_wrong_call_is_told():
    with pytest.raises(InputError, match="give the walls A and B in the order"):
        gz.windows(rattle(), "B.r", words="AC")
    with pytest.raises(InputError, match=r"r stands for A\.r = .* begin where they are equal, or name one of them"):
        gz.windows(rattle(), "r")
    with pytest.raises(InputError, match="orders of walls; an oscillator with one wall"):
        gz.windows(gz.pinball(), "d", words="A")


def test_values_are_counted_and_an_orbit_that_is_not_followed_is_named(monkeypatch):
    """Where one was not, as beside a branch point, all windows were lost to its message."""
    counted = []

    def broken(*_begin, **_limits):
        raise gz.GrazingError("no other branch was found")

    monkeypatch.setattr(word_windows, "continuation", broken)
    found = gz.windows(pair(), "B.sigma", 1, (3.0, 9.5), samples=2, progress=lambda *done: counted.append(done))
    assert counted[0] == (0, 2) and counted[-1] == (2, 2)
    assert found.sizes["window"] == 0 and "no other branch was found" in found.attrs["not_followed"]
    told = windows_study.words(windows_study.found(found), found, {"vary": ["B.sigma"]})
    assert any(line.startswith("not followed: <ImpactOrbit (AB), ") for line in told)


def test_the_shell_and_the_figure(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = "--walls A=newton,B=newton --alpha 0.1 --k 0.5 --omega 2 --cos 2 A.sigma=-0.5 A.r=0.8 B.sigma=0.5".split()
    tokens = [
        "windows",
        "B.r=0.4:0.95",
        *model,
        "--words",
        "ABB",
        "--N",
        "1",
        "--samples",
        "2",
        "-o",
        "w.nc",
        "-o",
        "w.png",
    ]
    assert main(tokens) == 0
    out = capsys.readouterr().out
    assert "1 ABB   0.412131" in out and "pd" in out
    assert gz.load("w.nc").word.values.tolist() == ["ABB"]
    drawn = gz.plot.windows(gz.load("w.nc"))
    assert drawn["names"][1].get_text() == "ABB"
    assert main([*tokens, "--sensitivity"]) == 2
    assert "derivatives of edges are those of windows over one wall" in capsys.readouterr().err
