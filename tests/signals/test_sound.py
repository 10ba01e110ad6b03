"""Sounds: pitch, length and loudness as asked for, impacts that are heard, and the words of errors."""

import numpy as np
import pytest
from scipy.io import wavfile

import grazing as gz


def test_a_free_motion_sounds_at_the_pitch_of_its_forcing(tmp_path):
    m = gz.pinball(d=5.0)
    tr = gz.trajectory(m, (5.0, 0.0), until=880 * m.period).isel(t=slice(50_000, None))
    rate, x = wavfile.read(gz.to_wav(tr, tmp_path / "a.wav", speed=440 * m.period, rate=22_050))
    assert rate == 22_050 and x.dtype == np.int16
    assert len(x) / rate == pytest.approx(float(tr.t[-1] - tr.t[0]) / (440 * m.period), abs=2 / rate)
    assert 31_000 < np.abs(x.astype(int)).max() <= 32_000
    heard = np.fft.rfftfreq(len(x), 1 / rate)[np.argmax(np.abs(np.fft.rfft(x)))]
    assert heard == pytest.approx(440.0, abs=1.0)


def test_an_impact_is_a_step_of_the_velocity(tmp_path):
    m = gz.pinball(d=0.12, V=0.4)
    tr = gz.trajectory(m, (0.1, 0.0), until=30 * m.period)
    _rate, x = wavfile.read(gz.to_wav(tr, tmp_path / "a.wav", speed=m.period, rate=8000))
    steps = np.flatnonzero(np.abs(np.diff(x.astype(int))) > 10_000) + 1
    want = np.ceil(tr.impact_time.values / m.period * 8000 - 1e-9)
    np.testing.assert_array_equal(steps, want)


def test_what_cannot_be_heard_is_said(tmp_path):
    held = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=1.0, offset=-3.0), reset=gz.newton(0.0))
    rest = gz.trajectory(held, (0.0, 0.0), until=10.0)
    still = {"m": 0.8, "c": 2.4, "k": 3200, "force": 0.0, "gap": 1.2e-3, "frequency": 14, "reset": gz.newton(0.7)}
    hanging = gz.trajectory(gz.Oscillator.from_si(**still), (0.0, 0.0), until=1.0)
    assert 0.0 < np.abs(hanging.v.values).max() < 1e-15  # rounding, which was heard at full loudness
    tr = gz.trajectory(gz.pinball(), (0.1, 0.0), until=10.0)
    for arguments, text in (
        ((rest, tmp_path / "a.wav"), "the motion rests: its velocity does not change"),
        ((hanging, tmp_path / "a.wav"), "the motion rests: its velocity does not change"),
        ((hanging, tmp_path / "a.wav", 1.0, "u"), "the motion rests: its position does not change"),
        ((tr, tmp_path / "a.mp3"), "allowed is '.wav'"),
        ((tr, tmp_path / "none" / "a.wav"), "cannot be written: No such file or directory"),
        ((tr, tmp_path / "a.wav", 1e9), "choose a lower speed"),
        ((tr, tmp_path / "a.wav", -1.0), "speed = -1; any positive number"),
        ((tr, tmp_path / "a.wav", 1.0, "w"), "of = 'w'; allowed are v"),
    ):
        with pytest.raises(gz.InputError, match=text), np.errstate(all="ignore"):
            gz.to_wav(*arguments)
    assert list(tmp_path.iterdir()) == []
