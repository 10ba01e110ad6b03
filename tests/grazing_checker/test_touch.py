"""Orbits that miss the wall, or are below it, by far less than a double's rounding: no decision rests on a float."""

from copy import deepcopy

import pytest
from mpmath import mp, mpf

import grazing as gz
from grazing.proof.certify import certify
from grazing_checker import Rejected, check
from grazing_checker.balls import double, precision
from grazing_checker.reading import exact
from tests.grazing_checker import truth
from tests.grazing_checker.documents import documents
from tests.grazing_checker.forgeries import fitting_matrix, sealed, system, text_of
from tests.proof.orbits import closed, without_impacts


def split(level):
    """Offset and sigma with offset - sigma = level, for k = 1, to far more digits than a double has."""
    offset = float(level)
    return offset, float(offset - level)


def swinging(level):
    """A rig whose free ball swings about a level."""
    offset, sigma = split(level)
    return gz.Oscillator(0.5, 1.0, gz.Forcing(omega=2.0, offset=offset, cos=(1.0,)), gz.newton(0.5), sigma=sigma)


def graze_of_the_swing():
    """The level at which it touches the wall: its amplitude."""
    return 1 / mp.sqrt(mpf(9) + 1)


def impacting(level):
    offset, sigma = split(level)
    pin = gz.pinball(V=0.4)
    forcing = gz.Forcing(pin.forcing.omega, offset=offset, cos=(1.0,))
    return gz.Oscillator(pin.alpha, pin.k, forcing, pin.reset, sigma=sigma)


def rig_of(level):
    data = deepcopy(documents()["gr"]["data"])
    data["model"]["sigma"] = (0.0).hex()
    return truth.Rig(data, level)


def graze_of_the_impacts():
    """The level at which the dip between the impacts is 0, by secants."""
    data = documents()["gr"]["data"]
    guess = [truth.middle(one) for one in data["claims"]["box"]]
    time = truth.exact(data["dip"]["time"])

    def height(level):
        rig = rig_of(level)
        return rig.lowest(truth.newton(rig.equations, guess), 0, time)

    a, b = (truth.middle(data["claims"]["value"]) + h for h in (mpf(0), mpf(10) ** -12))
    one, two = height(a), height(b)
    while abs(two) > mpf(10) ** -45:
        a, b, one = b, b - two * (b - a) / (two - one), two
        two = height(b)
    return b


@pytest.fixture(scope="module")
def grazes():
    with mp.workdps(60):
        return {"free": graze_of_the_swing(), "impacts": graze_of_the_impacts()}


def orbit_at(kind, level):
    if kind == "free":
        return without_impacts(swinging(level))
    old = documents()["stable"]["data"]["claims"]
    guess = [float(truth.middle(one)) for one in [*old["box"], *old["incoming"]]]
    found, residual = closed(impacting(level), 3, guess[:1], guess[1:2], guess[2:])
    assert residual < 1e-9
    return found


def moved(document, level):
    """The certificate with the wall elsewhere, its equations solved again by the checker's own code."""
    data = deepcopy(document["data"])
    data["model"]["offset"], data["model"]["sigma"] = (x.hex() for x in split(level))
    with precision(256):
        for _ in range(8):
            F, _D = system(data)
            for i, row in enumerate(data["preconditioner"]):
                step = sum((double(float.fromhex(c)) * f for c, f in zip(row, F, strict=True)), 0 * F[0])
                data["centre"][i] = text_of(exact(data["centre"][i]) - step)
    fitting_matrix(None, data, [])
    return sealed("periodic orbit", data, document["inequalities"])


@pytest.mark.parametrize("kind", ["free", "impacts"])
@pytest.mark.parametrize("digits", [14, 20, 28])
def test_a_miss_is_proven_and_its_mirror_image_refused(grazes, kind, digits):
    """Above by 10^-digits it is proven and true; below by as much it is refused, and only for what touches."""
    with mp.workdps(60):
        above, below = (grazes[kind] + sign * mpf(10) ** -digits for sign in (1, -1))
        good = certify(orbit_at(kind, above))
        assert good.proven, good.reason
        forged = moved(good.document, below)
        back = moved(forged, above)
    assert check(good.document) == good.statement
    assert truth.is_true("periodic orbit", good.document["data"]) == (True, "")
    assert check(back) == back["statement"]
    with pytest.raises(Rejected, match=r"height of (the orbit|flight 1 between its cuts)"):
        check(forged)
    assert truth.is_true("periodic orbit", forged["data"]) == (False, "flight 1 meets the wall")
