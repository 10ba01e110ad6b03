"""Samples: closed forms, the strobe map, rests and instants of impact, units, and the words of errors."""

import numpy as np
import pytest

import grazing as gz
from tests.models import MODELS

HARMONICS = gz.Oscillator(
    alpha=0.2, k=1.3, forcing=gz.Forcing(omega=0.9, offset=-0.4, cos=(1.0, 0.3), sin=(0.2, 0.0)),
    sigma=-0.3, reset=gz.newton(0.6),
)  # fmt: skip


@pytest.mark.parametrize("name", ["standard", "under-damped", "two harmonics"])
def test_samples_at_strobes_are_the_stroboscopic_map(name):
    m = MODELS[name]
    start = (m.sigma + 0.2, -0.1)
    found = gz.sample(gz.trajectory(m, start, until=20 * m.period), 16 / m.period)
    orbit = gz.stroboscopic_map(m).iterate(start, 20)
    np.testing.assert_allclose(found.u[::16], orbit[:, 0], atol=1e-12)
    np.testing.assert_allclose(found.v[::16], orbit[:, 1], atol=1e-12)


def test_a_thrown_ball_is_a_parabola_between_its_impacts():
    m = gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=0.05, offset=-2.0, cos=(0.0,)), reset=gz.newton(0.5))
    tr = gz.trajectory(m, (1.0, 0.0), until=1.9, samples=2)  # points of the trajectory are far apart: samples are not
    found = gz.sample(tr, 1000.0)
    t = found.t.values
    hit = np.array([0.0, 1.0, 2.0])  # the first hop lasts a second, from v = 1
    want = np.where(t < hit[1], 1.0 - t**2, (t - 1.0) - (t - 1.0) ** 2)
    np.testing.assert_allclose(found.u, want, atol=1e-13)
    np.testing.assert_allclose(found.v, np.where(t < hit[1], -2.0 * t, 1.0 - 2.0 * (t - 1.0)), atol=1e-13)
    assert found.v[1000] == 1.0  # at the impact: after it


def test_a_ball_at_rest_stays_until_it_is_released():
    m = gz.Oscillator(alpha=0.5, k=1, forcing=gz.Forcing(omega=1.0, offset=-0.5, cos=(1.0,)), reset=gz.newton(0.0))
    tr = gz.trajectory(m, (0.0, 0.0), 1.1, 3 * m.period)
    found = gz.sample(tr, 997.0)
    resting = (found.u == 0.0) & (found.v == 0.0)
    force = -0.5 + np.cos(found.t)
    assert 0.1 < resting.mean() < 0.9
    assert (force[resting] <= 1e-2).all()  # released within a sample of the zero of the force
    assert (found.u >= 0.0).all()


@pytest.mark.parametrize("model", [HARMONICS, MODELS["standard"]])
def test_the_equation_of_motion_holds_between_impacts(model):
    rate = 5000.0
    tr = gz.trajectory(model, (model.sigma + 0.3, 0.0), 0.7, 0.7 + 3 * model.period, samples=5)
    found = gz.sample(tr, rate)
    t, u, v = (found[name].values for name in ("t", "u", "v"))
    f, p = model.forcing, model.params
    force = p.get("offset", p.get("d")) + sum(
        c * np.cos(j * f.omega * (t + f.t0)) + s * np.sin(j * f.omega * (t + f.t0))
        for j, (c, s) in enumerate(zip(f.cos, f.sin, strict=True), 1)
    )
    inside = np.abs(t[:, None] - found.impact_time.values).min(axis=1) > 3 / rate
    slope = np.gradient(v, t)
    residual = slope + model.alpha * v + model.k**2 * u - force
    assert np.abs(residual[1:-1][inside[1:-1]]).max() < 1e-5  # second differences at this rate
    assert np.abs(np.gradient(u, t) - v)[1:-1][inside[1:-1]].max() < 1e-6


def test_two_rates_agree_where_they_meet_and_a_file_says_the_same(tmp_path):
    m = gz.pinball(d=0.12, V=0.4)
    tr = gz.trajectory(m, (0.1, 0.0), until=100.0)
    coarse, fine = gz.sample(tr, 16.0), gz.sample(tr, 64.0)
    np.testing.assert_array_equal(coarse.u, fine.u[::4])
    gz.save(tr, tmp_path / "a.nc")
    np.testing.assert_array_equal(gz.sample(gz.load(tmp_path / "a.nc"), 16.0).v, coarse.v)
    np.testing.assert_array_equal(coarse.impact_time, tr.impact_time)


def test_a_low_rate_is_said_and_not_refused():
    tr = gz.trajectory(HARMONICS, (0.3, 0.0), until=30.0)
    lowest = 2 * 2 / HARMONICS.period  # the third harmonic is zero
    with pytest.warns(UserWarning, match="twice the frequency of harmonic 2 of the forcing"):
        gz.sample(tr, 0.999 * lowest)
    gz.sample(tr, 1.001 * lowest)


def test_what_is_wrong_is_said():
    tr = gz.trajectory(gz.pinball(), (0.1, 0.0), until=10.0)
    for wrong, text in (
        ((tr, 0.0), "rate = 0; any positive number"),
        ((tr, "fast"), "rate = 'fast'"),
        ((tr, 1e15), "choose a lower rate"),
        ((tr.drop_vars("u"), 10.0), "give a dataset as gz.trajectory returns it"),
        (([1, 2], 10.0), "give a dataset as gz.trajectory returns it"),
    ):
        with pytest.raises(gz.InputError, match=text):
            gz.sample(*wrong)
    del tr.attrs["parameter_k"]
    with pytest.raises(gz.InputError, match="does not say its parameter 'k'"):
        gz.sample(tr, 10.0)


def test_a_ball_on_a_table_has_no_samples(tmp_path):
    table = gz.table([gz.drain("out", (0, 0), (3, 0))], tilt=0.3)
    flown = gz.trajectory(table, (1, 1, 0, 0), until=9.0)
    for call in (
        lambda: gz.sample(flown, 10.0), lambda: gz.spectrum(flown), lambda: gz.to_wav(flown, tmp_path / "ball.wav"),
        lambda: gz.sample(gz.launches(table, (1, 1), 0.3, 1.0), 10.0),
    ):  # fmt: skip
        with pytest.raises(gz.InputError, match="of a ball on a table; samples, sounds and spectra are of oscillators"):
            call()
    other = flown.drop_vars("exit")
    with pytest.raises(gz.InputError, match=r"^trajectory is a dataset with [^\n]{1,80} and \d+ more; give"):
        gz.sample(other, 10.0)


def test_a_parameter_of_a_law_may_begin_like_an_amplitude_of_a_wall():
    law = gz.reset(lambda v, p: -p.cosine * v, cosine=0.6)
    force = gz.Forcing(omega=2.0, cos=(2.0,))

    def samples(law):
        model = gz.Oscillator(0.1, 0.5, forcing=force, walls=(gz.wall(-0.5, law), gz.wall(0.5, law)))
        return gz.sample(gz.trajectory(model, (0.1, 0.0), until=10.0), 20.0)

    np.testing.assert_array_equal(samples(law).u, samples(gz.newton(0.6)).u)
