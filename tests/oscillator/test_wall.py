"""Walls and models between them: what is refused, what parameters are called, what each wall sees."""

import copy
import pickle

import numpy as np
import pytest

import grazing as gz

LAW = gz.newton(0.8)
FORCE = gz.Forcing(omega=2.0)


def between(low=-0.5, high=0.5, law=LAW, law2=None, **motions):
    """A model between two walls; ``motions`` are those of the lower (a) and of the upper one (b)."""
    second = gz.newton(0.6) if law2 is None else law2
    walls = gz.wall(low, law, motion=motions.get("a")), gz.wall(high, second, motion=motions.get("b"))
    return gz.Oscillator(0.1, 0.5, FORCE, walls=walls)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: gz.wall("low", LAW), "position = 'low' is no quantity"),
        (lambda: gz.wall(0.0, 0.8), "law of a wall is 0.8; give gz.newton"),
        (lambda: gz.wall(0.0, LAW, side="left"), "side = 'left'; allowed are 'below' and 'above'"),
        (lambda: gz.wall(0.0, LAW, motion=0.1), "motion is 0.1; give a gz.Forcing"),
        (lambda: gz.wall(0.0, LAW, motion=gz.Forcing(omega=1.0, offset=0.1)), "add it to the position"),
        (lambda: gz.wall(0.0, LAW, name="C"), "allowed is one capital letter other than C and S"),
        (lambda: gz.wall(0.0, LAW, name="left"), "one capital letter"),
        (lambda: gz.Oscillator(0, 1, FORCE, LAW, walls=[gz.wall(0.0, LAW)]), "walls are given beside reset; each wall"),
        (lambda: gz.Oscillator(walls=[gz.wall(0.0, LAW)]), "between walls needs alpha, forcing as well"),
        (lambda: gz.Oscillator(0, 1, FORCE, sigma=1.0, walls=[gz.wall(0.0, LAW)]), "walls are given beside sigma"),
        (lambda: gz.Oscillator(0, 1, FORCE, walls=[]), r"walls are \[\]; give one or two of gz.wall"),
        (lambda: gz.Oscillator(0, 1, FORCE, walls=(1.0, 2.0)), "give one or two of gz.wall"),
        (lambda: gz.Oscillator(0, 1, FORCE, walls=[gz.wall(i, LAW) for i in range(3)]), "touches two at most"),
        (lambda: between(0.5, 0.5), "both walls are at 0.5"),
        (lambda: between(a=gz.Forcing(omega=3.0)), "no whole multiple of the forcing's 2: there would be no period"),
        (lambda: between(a=gz.Forcing(omega=2.0, cos=(0.9,)), b=gz.Forcing(omega=4.0, cos=(-0.2,))), "move them apart"),
        (lambda: gz.Oscillator(1, -1, FORCE, walls=[gz.wall(0.0, LAW)]), "k = -1; allowed is k >= 0"),
        (lambda: gz.Oscillator(0, 1, lambda t: t, walls=[gz.wall(0.0, LAW)]), "a force is a Fourier series here"),
        (lambda: between().replace(**{"A.q": 1.0}), r"unknown parameter 'A.q' of the model. .*B.sigma"),
        (lambda: between().replace(**{"B.r": 2.0}), "B.r = 2; allowed is 0 <= B.r <= 1"),
        (lambda: between().replace(**{"A.sigma": 0.6}), "the one at 0.6"),
        (lambda: gz.stroboscopic_map(between()).orbit((0.7, 0.0), 1), "inside wall B, which is above it: u = 0.7"),
        (lambda: gz.trajectory(between(), (-0.7, 0.0)), "inside wall A, which is below it: u = -0.7"),
        (lambda: gz.normal_form(between(), "omega"), "one wall below it, at rest"),
    ],
)
def test_wrong_walls_are_refused_with_what_is_allowed(make, said):
    with pytest.raises(gz.InputError, match=said):
        make()


def test_both_sides_swapped_are_refused():
    walls = gz.wall(-0.5, LAW, side="above"), gz.wall(0.5, LAW, side="below")
    with pytest.raises(gz.InputError, match="the ball flies between two walls, so the lower one is below it"):
        gz.Oscillator(0.1, 0.5, FORCE, walls=walls)
    with pytest.raises(gz.InputError, match="both walls are called B"):
        gz.Oscillator(0.1, 0.5, FORCE, walls=(gz.wall(-1, LAW, name="B"), gz.wall(1, LAW, name="B")))


def test_a_law_may_not_name_its_parameters_as_the_model_does():
    def law(v, p):
        return -p.omega * v

    with pytest.raises(gz.InputError, match="law of wall A has the name of a model parameter"):
        gz.Oscillator(0.1, 0.5, FORCE, walls=[gz.wall(0.0, gz.reset(law, omega=0.5))])


def test_parameters_are_flat_and_each_wall_has_its_own():
    m = between(law2=gz.active(r=0.6, V=0.2), b=gz.Forcing(omega=4.0, cos=(0.1,), sin=(0.05,)))
    assert list(m.params) == [
        "alpha", "k", "omega", "t0", "offset", "cos1", "sin1", "A.sigma", "A.r",
        "B.sigma", "B.cos1", "B.sin1", "B.cos2", "B.sin2", "B.r", "B.V",
    ]  # fmt: skip
    assert m.params["B.cos2"] == 0.1 and m.params["B.sin2"] == 0.05 and m.params["B.cos1"] == 0.0
    for name, value in m.params.items():
        low = {"omega": 2.5, "A.sigma": -0.6, "B.sigma": 0.7}.get(name, 0.5 * value + 0.01)
        assert m.replace(**{name: low}).params == {**m.params, name: low}, name


def test_one_wall_keeps_the_names_of_an_oscillator():
    table = gz.wall(0.0, gz.active(r=0.8, V=0.1), motion=gz.Forcing(omega=2.0, sin=(0.1,), cos=()))
    m = gz.Oscillator(0.1, 0.5, FORCE, walls=[table])
    assert list(m.params)[-5:] == ["sigma", "A.cos1", "A.sin1", "r", "V"]


def test_walls_are_named_from_below_and_names_given_are_kept():
    high, low = gz.wall(0.5, LAW, name="A"), gz.wall(-0.5, LAW)
    m = gz.Oscillator(0.1, 0.5, FORCE, walls=(high, low))
    assert m.names == "BA" and [wall.side for wall in m.walls] == ["below", "above"]


def test_models_pickle_and_copy_and_are_equal():
    m = between(a=gz.Forcing(omega=2.0, cos=(0.1,)))
    for again in (pickle.loads(pickle.dumps(m)), copy.deepcopy(m), m.replace()):
        assert again.params == m.params and repr(again) == repr(m)
    P = gz.stroboscopic_map(m)
    again = pickle.loads(pickle.dumps(P))
    assert (again.iterate((0.1, 0.2), 5) == P.iterate((0.1, 0.2), 5)).all()


@pytest.mark.parametrize("shift", [0.0, 0.3, -1.7])
def test_a_motion_is_turned_to_the_time_shift_of_the_forcing(shift):
    forcing = gz.Forcing(omega=1.5, t0=0.4)
    motion = gz.Forcing(omega=3.0, t0=0.4 + shift, cos=(0.1, 0.03), sin=(0.02, 0.05))
    m = gz.Oscillator(0.1, 0.5, forcing, walls=[gz.wall(0.2, LAW, motion=motion)])
    t = np.linspace(-1.0, 5.0, 41)
    angle = 3.0 * (t + 0.4 + shift)
    said = 0.2 + 0.1 * np.cos(angle) + 0.02 * np.sin(angle) + 0.03 * np.cos(2 * angle) + 0.05 * np.sin(2 * angle)
    at, speed = m.places_at(t)
    np.testing.assert_allclose(at[0], said, atol=2e-15)
    np.testing.assert_allclose(speed[0][1:-1], np.gradient(said, t)[1:-1], atol=0.2)
    assert (m.replace(t0=0.7).places_at(t - 0.3)[0] - at).max() < 2e-15  # force and walls shift together


def test_each_wall_sees_the_forces_that_its_motion_makes():
    """sign (f - z'' - alpha z' - k^2 z), by differences of the motion."""
    waves = gz.Forcing(omega=2.0, cos=(0.05, 0.01), sin=(0.03,))
    m = between(a=waves, b=gz.Forcing(omega=2.0, sin=(0.07,), cos=()))
    t, h = np.linspace(0.0, 3.0, 17), 1e-4
    for j, sign in enumerate((1.0, -1.0)):
        z = [m.places_at(t + d)[0][j] - m.walls[j].position for d in (-h, 0.0, h)]
        bend, slope = (z[2] - 2 * z[1] + z[0]) / h**2, (z[2] - z[0]) / (2 * h)
        seen = m.seen[j]
        f, g = m.forcing, seen.forcing
        force = [
            w.offset
            + sum(
                c * np.cos(i * 2.0 * t) + s * np.sin(i * 2.0 * t)
                for i, (c, s) in enumerate(zip(w.cos, w.sin, strict=True), 1)
            )
            for w in (f, g)
        ]
        np.testing.assert_allclose(force[1], sign * (force[0] - bend - 0.1 * slope - 0.25 * z[1]), atol=1e-7)
        assert seen.sigma == sign * m.walls[j].position


def test_the_room_between_walls_is_a_lower_bound_near_the_truth():
    random = np.random.default_rng(5)
    t = np.linspace(0.0, 2 * np.pi / 2.0, 20001)
    for _ in range(20):
        a = gz.Forcing(omega=2.0, cos=random.normal(0, 0.03, 3), sin=random.normal(0, 0.03, 3))
        b = gz.Forcing(omega=4.0, cos=random.normal(0, 0.03, 2), t0=random.normal())
        m = between(a=a, b=b)
        at = m.places_at(t)[0]
        true, room = (at[1] - at[0]).min(), m.rooms(np.array([list(m.params.values())]))[0]
        assert true - 2e-3 < room <= true + 1e-12


def test_a_model_over_one_wall_says_of_it_what_the_same_wall_given_by_itself_does():
    """One contract serves both: what asks a rig need not know which it has."""
    forcing, law = gz.Forcing(omega=2.2, t0=0.3, offset=0.12, cos=(1.0, 0.2), sin=(0.1, 0.0)), gz.active(r=0.8, V=0.4)
    one = gz.Oscillator(3.0, 1.0, forcing, law, sigma=-0.2)
    other = gz.Oscillator(3.0, 1.0, forcing, walls=[gz.wall(-0.2, law)])
    rows, times = np.array([list(one.params.values())]), np.linspace(-1.0, 5.0, 7)
    assert (one.walled, other.walled) == (False, True)
    assert one.walls == other.walls
    assert (one.names, one.moves, one.symmetric) == (other.names, other.moves, other.symmetric) == ("A", False, False)
    assert one.places == other.places
    assert one.seen[0] is one
    assert dict(other.seen[0].params) == dict(one.params)
    for a, b in zip(one.rows_seen(rows), other.rows_seen(rows), strict=True):
        np.testing.assert_array_equal(a, b)
    for a, b in zip(one.places_at(times), other.places_at(times), strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(one.rooms(rows), other.rooms(rows))
    P, Q = gz.stroboscopic_map(one), gz.stroboscopic_map(other)
    assert (P.section, Q.section) == ("strobe", "strobe")
    assert P.origin.rig is one
    assert Q.origin.rig is other
    assert (P.walled, Q.walled) == (None, other)


def test_two_places_of_sigma_are_told_how_to_be_two_walls():
    with pytest.raises(
        gz.InputError, match=r"sigma = \(-0\.1, 0\.1\).*walls=\[gz\.wall\(low, law\), gz\.wall\(high, law\)\]"
    ):
        gz.pinball(sigma=(-0.1, 0.1))
