"""Spectra: lines whose height is known in closed form, orders, and the words of errors."""

import numpy as np
import pytest

import grazing as gz


def steady(m, periods=40, rate=64):
    """A free motion after its transient, a whole number of periods of it."""
    tr = gz.trajectory(m, (m.sigma + 1.0, 0.0), until=(60 + periods) * m.period)
    return gz.sample(tr, rate / m.period).isel(t=slice(60 * rate, (60 + periods) * rate))


def test_lines_of_a_free_motion_are_its_response_to_each_harmonic():
    m = gz.Oscillator(
        alpha=0.5, k=1.5, forcing=gz.Forcing(omega=1.1, cos=(1.0, 0.0, 0.3), sin=(0.2, 0.4, 0.0)), sigma=-9.0,
        reset=gz.newton(0.5),
    )  # fmt: skip
    for of, power in (("u", 0), ("v", 1)):
        found = gz.spectrum(steady(m), of, window="boxcar")
        for j, size in enumerate((np.hypot(1.0, 0.2), 0.4, 0.3), 1):
            w = 1.1 * j
            want = size * w**power / np.hypot(1.5**2 - w * w, 0.5 * w)
            line = found.isel(frequency=40 * j)
            assert float(line.order) == pytest.approx(j, abs=1e-12)
            assert float(line.frequency) == pytest.approx(w / (2 * np.pi), rel=1e-12)
            assert float(line.amplitude) == pytest.approx(want, rel=1e-9)
        rest = found.amplitude.values[np.abs(found.order.values % 1.0 - 0.5) < 0.4]
        assert rest.max() < 1e-9


def test_a_motion_of_three_periods_has_lines_at_thirds():
    m = gz.pinball(d=0.12, V=0.4)
    tr = gz.trajectory(m, (0.1, 0.0), until=120 * m.period)
    found = gz.spectrum(gz.sample(tr, 64 / m.period).isel(t=slice(30 * 64, 120 * 64)), window="boxcar")
    lines = found.order.values[found.amplitude.values > 1e-8]
    assert len(lines) > 50
    np.testing.assert_allclose(lines * 3, np.round(lines * 3), atol=1e-9)
    assert np.any(np.abs(lines % 1.0 - 1 / 3) < 1e-9)


def test_a_window_keeps_the_height_of_a_line():
    m = gz.Oscillator(alpha=0.5, k=1.5, forcing=gz.Forcing(omega=1.1), sigma=-9.0, reset=gz.newton(0.5))
    hann, plain = (gz.spectrum(steady(m), window=window).amplitude.max() for window in ("hann", "boxcar"))
    assert float(hann) == pytest.approx(float(plain), rel=1e-3)


@pytest.mark.parametrize("window", ["boxcar", "hann"])
def test_the_line_at_half_the_rate_has_the_height_of_samples_that_take_turns(window):
    found = steady(gz.pinball(d=0.5), periods=4)
    assert len(found.t) % 2 == 0
    found["u"][:] = 5.0 + 0.7 * np.cos(np.pi * np.arange(len(found.t)))
    assert gz.spectrum(found, window=window).amplitude[-1] == pytest.approx(0.7, rel=1e-12)  # it was 0.99
    odd = found.isel(t=slice(1, None))
    odd["u"][:] = 0.3 * np.cos(2.0 * np.pi * np.arange(len(odd.t)) * (len(odd.t) // 2) / len(odd.t))
    assert gz.spectrum(odd, window="boxcar").amplitude[-1] == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize("window, lost", [("hann", 0.1512), ("flattop", 0.0012)])
def test_a_window_lowers_a_line_between_two_frequencies(window, lost):
    """The line at 1 has the height 1; a record of 20.5 cycles has frequencies at 20/20.5 and 21/20.5."""
    forcing = gz.Forcing(omega=2 * np.pi, cos=(2.0,))
    m = gz.Oscillator(alpha=3, k=1, forcing=forcing, sigma=-9, reset=gz.newton(0.7))
    recorded = gz.sample(gz.trajectory(m, (0, 0), until=60.5), rate=40).isel(t=slice(40 * 40, -1))
    height = 2 / np.hypot(1 - forcing.omega**2, 3 * forcing.omega)
    assert 1 - gz.spectrum(recorded, window=window).amplitude.max() / height == pytest.approx(lost, abs=2e-4)


def test_what_is_wrong_is_said():
    tr = gz.trajectory(gz.pinball(), (0.1, 0.0), until=10.0)
    recorded = gz.sample(tr, 10.0)
    for arguments, text in (
        ((tr,), r"take samples first: gz.sample\(trajectory, rate\)"),
        ((recorded.isel(t=[0, 1, 3, 4, 5, 6, 7, 8, 9]),), "not equally spaced"),
        ((recorded.isel(t=slice(5)),), "there are 5 samples"),
        ((recorded, "w"), "of = 'w'; allowed are u, the position, and v, the velocity"),
        ((recorded, "u", "wide"), "window = 'wide'"),
        ((recorded, "u", 1e5), r"window = 100000\.0 gives weights that are no numbers"),
        ((recorded, "u", "gaussian"), r"window = 'gaussian'; give one of scipy"),
        ((recorded, "u", ()), r"window = \(\)"),
        ((recorded, "u", ("chebwin", 1e5)), "window = "),
    ):
        with pytest.raises(gz.InputError, match=text):
            gz.spectrum(*arguments)
