"""A law that raises or returns what it must not, somewhere: each study says so, once, with the law's own line."""

import warnings

import numpy as np
import pytest

import grazing as gz
from grazing import InputError, UserCodeError


def no_number(v, p):
    return float("nan") if -0.99 < v < -0.11 else -v * p.r


def by_zero(v, p):
    return -v / (v - v) if -0.99 < v < -0.11 else -v * p.r


def by_parameter(v, p):
    return -v * p.r / p.c


def model(law):
    made = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=2.8), sigma=-0.1, reset=gz.reset(law, r=0.5, c=1.0))
    return made.replace(c=0.0) if law is by_parameter else made


LAWS = {no_number: "returned nan", by_zero: "-v / (v - v)", by_parameter: "-v * p.r / p.c"}
OMEGA = np.linspace(2.0, 3.0, 4)
STUDIES = {
    "iterate": lambda P: P.iterate((0.5, 0.0), 20),
    "diagram": lambda P: gz.orbit_diagram(P, "omega", OMEGA, starts=4, transient=20, keep=5),
    "lyapunov": lambda P: gz.lyapunov(P, "omega", OMEGA, starts=4, steps=20),
    "chart": lambda P: gz.chart(P, {"omega": OMEGA, "alpha": [0.1, 0.2]}, starts=4, transient=20, keep=10),
    "response": lambda P: gz.response(P, "omega", OMEGA, starts=4, transient=20, keep=10),
    "bifurcations": lambda P: gz.bifurcation_diagram(P, "omega", OMEGA, starts=4, transient=20, keep=10),
}


@pytest.mark.parametrize("study", STUDIES)
@pytest.mark.parametrize("law", LAWS)
def test_a_study_warns_with_the_law_and_its_line(law, study):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        try:
            STUDIES[study](gz.stroboscopic_map(model(law)))
        except UserCodeError as error:
            said = str(error)
        else:
            said = str(seen[0].message)
    assert LAWS[law] in said and f"the reset law {law.__name__}" in said
    assert len(seen) <= 2


def test_a_density_says_once_what_a_law_did():
    """Its trial, which finds the range, said it too, of other numbers of orbits."""
    P = gz.stroboscopic_map(model(lambda v, p: float("nan") if -0.3 < v < -0.2 else -v * p.r))
    few = {"starts": 40, "transient": 20, "keep": 500}  # many more than the trial looks at
    with pytest.warns(RuntimeWarning, match="returned nan") as seen:
        gz.density(P, "omega", OMEGA, bins=4, **few)
    assert len(seen) == 1


def test_coexistence_says_once_what_a_law_did():
    """Its second flight, which times how orbits settle, said it too."""
    P = gz.stroboscopic_map(model(lambda v, p: float("nan") if -0.3 < v < -0.2 else -v * p.r))
    with pytest.warns(RuntimeWarning, match="returned nan") as seen:
        gz.coexistence(P, "omega", OMEGA, starts=9, transient=20, keep=8)
    assert len(seen) == 1


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("run", [
    lambda m: gz.trajectory(m, (0.5, 0.0)), gz.testing.check_model,
    lambda m: gz.testing.check_map(gz.stroboscopic_map(m)),
])  # fmt: skip
def test_what_needs_a_whole_law_raises_with_its_line_and_nothing_before(law, run):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserCodeError) as error:
            run(model(law))
    assert LAWS[law] in str(error.value)


def test_closed_forms_try_the_law_in_python():
    with pytest.raises(UserCodeError, match=r"ZeroDivisionError.*in line \d+ of .*-v \* p\.r / p\.c"):
        gz.normal_form(model(by_parameter), "offset")
    with pytest.raises(UserCodeError, match=r"contraction .*ZeroDivisionError"):
        gz.reset(no_number, contraction=lambda p: (1.0 / (p.r - p.r), 1.0), r=0.5)


def test_two_stops_and_a_force_as_a_function_are_told_what_is_possible():
    forcing, law = gz.Forcing(omega=1.0), gz.newton(0.5)
    for sigma in ((-1.0, 1.0), [0.0]):
        with pytest.raises(InputError, match=r"the place of a single wall.*walls=\[gz\.wall"):
            gz.Oscillator(alpha=0.1, k=1, forcing=forcing, sigma=sigma, reset=law)
    with pytest.raises(InputError, match=r"Fourier series.*gz\.Forcing.*from_samples"):
        gz.Oscillator(alpha=0.1, k=1, forcing=np.cos, reset=law)
    with pytest.raises(InputError, match=r"one amplitude per harmonic.*Fourier series"):
        gz.Forcing(omega=1.0, cos=np.cos)


def whole(v, p):
    return 1 if -v > p.s else 0


def into_the_wall(v, p):
    return -1.0 if -v > p.s else -p.r * v


def forgetful(v, p):
    if -v <= p.s:
        return -p.r * v


def falling(law, **params):
    """A ball that falls on a wall, from a height that gives it a speed of 2 and more."""
    return gz.Oscillator(0.0, 0.0, gz.Forcing(2.0, offset=-2.0, cos=()), gz.reset(law, **params))


def test_whole_numbers_are_velocities():
    """An address was called as if a float lay there: after every impact the ball stood still, and rested for ever."""
    m = falling(whole, s=0.6)
    flown = gz.trajectory(m, (1.0, -1.5), until=6.0)
    assert flown.trust.item() == "certified" and (flown.v_plus.values == 1.0).all()
    assert flown.impact_time.values == pytest.approx((1.5 - 1.25) / 1.0 * 2.0 + np.arange(6), abs=1e-12)
    orbit = gz.stroboscopic_map(m).orbit((1.0, -1.5), 2)
    assert orbit.letters.sum() == 6 and not orbit.outcomes.any()


@pytest.mark.parametrize("algorithm", ["scalar", "block"])
def test_no_ball_is_let_through_the_wall(algorithm):
    """The block took a velocity into the wall for a departure: the ball went on below it, and was ok."""
    P = gz.stroboscopic_map(falling(into_the_wall, r=0.8, s=2.7))
    lanes = np.array([[[1.3575, 0.1], [-1.4495, 0.0]]])
    with pytest.warns(RuntimeWarning, match=r"returned -1 for v_minus = -2\.7"):
        found = P.run_columns([list(P.params.values())], lanes, 0, 3, records=3, algorithm=algorithm)
    assert found.outcomes[0, 0, 0] == gz.Outcome.bad_law
    assert np.isnan(found.points[0, :, :, 0]).all() and (found.points[0, :, 0, 1] >= 0.0).all()


def test_a_law_that_returns_nothing_somewhere_is_named():
    m = falling(forgetful, r=0.8, s=2.0)
    for run in (lambda: gz.trajectory(m, (1.0, -1.5), until=3.0), lambda: gz.stroboscopic_map(m).orbit((1.0, -1.5), 2)):
        with pytest.raises(UserCodeError, match="the reset law forgetful raised TypeError"):
            run()


def fast_is_nan(v, p):
    return float("nan") if -v > p.s else -0.8 * v


def one_argument(v):
    return -v


def between_walls(law):
    push = gz.Forcing(2.0, offset=-2.0, cos=())
    return gz.Oscillator(0.0, 0.0, push, walls=(gz.wall(0.0, gz.reset(law, s=2.7)), gz.wall(50.0, gz.newton(0.5))))


def rising(law, *lower):
    """A ball that falls upwards on a wall that moves."""
    shaken = gz.wall(5.0, gz.reset(law, s=2.7), "above", motion=gz.Forcing(2.0, sin=(0.05,), cos=()))
    return gz.Oscillator(0.0, 0.0, gz.Forcing(2.0, offset=2.0, cos=()), walls=(*lower, shaken))


ENDING = {
    "strobe": (lambda: gz.stroboscopic_map(falling(fast_is_nan, s=2.7)), (1.3575, -1.4495)),
    "impact": (lambda: gz.impact_map(falling(fast_is_nan, s=2.7)), (0.2, 3.5)),
    "walls": (lambda: gz.stroboscopic_map(between_walls(fast_is_nan)), (1.3575, -1.4495)),
    "impact between walls": (lambda: gz.impact_map(between_walls(fast_is_nan)), (0.2, 3.5)),
    "impact above": (lambda: gz.impact_map(rising(fast_is_nan)), (0.2, -3.5)),
    "impact with the upper": (lambda: gz.impact_map(rising(fast_is_nan, gz.wall(0.0, gz.newton(0.5)))), (0.2, -3.5)),
}


@pytest.mark.parametrize("made", ENDING)
def test_an_orbit_that_ended_stays_ended_and_the_warning_names_law_and_caller(made):
    # later steps had outcome 0 beside NaN; only the strobe said anything, and it named a line of the package
    P, state = ENDING[made][0](), ENDING[made][1]
    with pytest.warns(RuntimeWarning, match=r"the reset law fast_is_nan returned nan .*test_broken_law\.py") as seen:
        found = P.orbit(state, 5)
    assert (found.outcomes == gz.Outcome.bad_law).all() and np.isnan(found.points[1:]).all()
    assert f"line {fast_is_nan.__code__.co_firstlineno} of" in str(seen[0].message) and seen[0].filename == __file__


def test_a_law_that_cannot_be_called_is_named_by_its_own_line():
    with pytest.raises(UserCodeError) as error:
        falling(one_argument, s=2.7)
    said = str(error.value)
    assert f"defined in line {one_argument.__code__.co_firstlineno} of {__file__}" in said and "reset.py" not in said
