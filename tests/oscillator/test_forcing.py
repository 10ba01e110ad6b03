"""Forces that are given by their values: the series that made them, what is left out, and the words of errors."""

import warnings

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import InputError


def values(force, n):
    """Values of a force at n instants of one period from -t0 on, from its definition."""
    angles = 2.0 * np.pi * np.arange(n) / n
    cos = sum(a * np.cos(j * angles) for j, a in enumerate(force.cos, start=1))
    sin = sum(b * np.sin(j * angles) for j, b in enumerate(force.sin, start=1))
    return force.offset + cos + sin


@pytest.mark.parametrize("n", [7, 8, 33])
def test_samples_of_a_series_give_the_series(n):
    force = gz.Forcing(omega=1.7, t0=0.3, offset=-0.4, cos=(1.0, -0.2, 0.0), sin=(0.5, 0.0, 0.3))
    found = gz.Forcing.from_samples(values(force, n), 1.7, 3, t0=0.3)
    assert (found.omega, found.t0) == (1.7, 0.3) and found.offset == pytest.approx(-0.4, abs=1e-15)
    np.testing.assert_allclose([found.cos, found.sin], [force.cos, force.sin], rtol=0.0, atol=1e-15)


def test_a_motion_under_samples_is_that_under_the_series():
    force = gz.Forcing(omega=1.1, offset=0.1, cos=(1.0, 0.4))
    sampled = gz.Forcing.from_samples(values(force, 12), 1.1, 2)
    one, other = (
        gz.trajectory(gz.Oscillator(alpha=0.3, k=1.0, forcing=f, reset=gz.newton(0.8)), (0.5, 0.0), until=36.0)
        for f in (force, sampled)
    )
    assert one.sizes["impact"] >= 4
    np.testing.assert_allclose(one.impact_time, other.impact_time, rtol=0.0, atol=1e-12)


def test_what_is_left_out_is_said_and_is_the_greatest_difference():
    square = np.where(np.arange(64) < 32, 1.0, -1.0)
    with pytest.warns(UserWarning, match=r"^5 harmonics differ from the samples by up to ") as said:
        force = gz.Forcing.from_samples(square, 2.0, 5)
    error = np.abs(values(force, 64) - square).max()
    assert f"by up to {error:.2g}, of a force that goes from -1 to 1; allowed are up to 31" in str(said[0].message)
    assert said[0].filename == __file__
    with pytest.warns(
        UserWarning, match=r"31 harmonics differ from the samples by up to 0.1, of a force that goes from -1.1 to 1.1$"
    ):  # the 32nd has a cosine alone
        gz.Forcing.from_samples(square + 0.1 * (-1.0) ** np.arange(64), 2.0, 31)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        constant = gz.Forcing.from_samples([3, 3, 3], 2.0, 1)
    assert (constant.offset, constant.cos, constant.sin) == (3.0, (0.0,), (0.0,))


@pytest.mark.parametrize(
    ("samples", "harmonics", "said"),
    [
        ([1.0, 2.0], 1, "give the values of the force in one period, at least 3 finite numbers"),
        ([1.0, np.nan, 2.0], 1, "at least 3 finite numbers"),
        ([[1.0, 2.0, 3.0]], 1, "at least 3 finite numbers"),
        ("abc", 1, "at least 3 finite numbers"),
        ([1.0, 2.0, 3.0j], 1, "at least 3 finite numbers"),
        ([1.0, 2.0, 3.0, 4.0], 2, "harmonics = 2; 4 samples determine 1 at most"),
        ([1.0, 2.0, 3.0, 4.0], 0, "harmonics = 0"),
    ],
)
def test_samples_that_determine_no_series(samples, harmonics, said):
    with pytest.raises(InputError, match=said):
        gz.Forcing.from_samples(samples, 2.0, harmonics)
