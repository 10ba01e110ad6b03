"""Maps by pieces: the step that is made of them, copies, and what a wrong one is told."""

import copy
import pickle
from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import jit_disabled


def left(state, p):
    return (p.a * state[0] + p.mu,)


def right(state, p):
    return (p.b * state[0] + p.mu + p.l,)


def border(state, p):
    return state[0]


def upper(state, p):
    return state[0] - 1.0


def flat(state, p):
    return (0.5,)


PARAMS = {"a": 0.4, "b": 0.7, "mu": 0.2, "l": -0.5}
PIECES = {"L": left, "R": right}
LINES = gz.Map(pieces=PIECES, border=border, params=PARAMS, box=((-1.0, 1.0),))
THREE = gz.Map(pieces={"A": left, "B": right, "C": flat}, border=(border, upper), params=PARAMS, box=((-1.0, 2.0),))


def test_the_sign_of_the_border_chooses():
    for x, letter, after in ((-0.5, 0, 0.0), (0.5, 1, 0.05), (0.0, 1, -0.3)):
        image, chosen = LINES((x,))
        assert chosen == letter and image[0] == pytest.approx(after, abs=1e-15)
    assert LINES.letters == "LR"
    assert [gz.describe(int(LINES.orbit((x,), 1).outcomes[0]))[:9] for x in (-0.5, 0.0, 0.5)] == [
        "ok",
        "ambiguous",
        "ok",
    ]


def test_the_first_negative_border_chooses_among_three_pieces():
    assert [THREE((x,))[1] for x in (-0.1, 0.0, 0.9, 1.0, 3.0)] == [0, 1, 1, 2, 2]
    assert THREE((3.0,))[0] == 0.5 and THREE.letters == "ABC"


def test_a_map_by_pieces_keeps_the_laws_of_maps():
    gz.testing.check_map(LINES, steps=5)
    assert LINES.replace(mu=0.25).params["mu"] == 0.25 and LINES.replace(mu=0.25).pieces == PIECES


def test_copies_are_equal():
    for P in (LINES, THREE):
        for other in (pickle.loads(pickle.dumps(P)), copy.deepcopy(P), copy.copy(P)):
            assert other == P and other((0.3,)) == P((0.3,)) and other.images()._code == P.images()._code
        assert pickle.loads(pickle.dumps(P.replace(a=0.1))) == P.replace(a=0.1) != P


def test_a_step_of_the_library_is_held_to_its_pieces():
    G = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    gz.testing.check_map(G, steps=4)
    for pieces, side in (({"L": drifting, "R": drifting}, border), (G.pieces, upper)):
        with pytest.raises(
            AssertionError, match=r"piece and step differ at|the borders choose piece 0, the step letter 1"
        ):
            gz.testing.check_map(replace(G, pieces=pieces, border=side), steps=4)


def drifting(state, p):
    return (p.lam * state[0] + p.mu + 1e-15,)


@pytest.mark.parametrize("P", [LINES, THREE])
def test_images_hold_beyond_the_border(P):
    images, borders = P.images()(P.packed()[1][None], 0, np.array([[1.5], [-1.5]]), [0, 1], 0.0)
    assert images[:, 0] == pytest.approx([0.8, -1.35], abs=1e-15)
    assert borders.T[0].tolist() == [1.5, -1.5]


def test_a_piece_that_has_no_value_beyond_its_border():
    def root(state, p):
        return (p.mu - sqrt(state[0]),)

    P = gz.Map(pieces={"L": left, "R": root}, border=border, params=PARAMS, box=((-1.0, 1.0),))
    images, _borders = P.images()(P.packed()[1][None], 0, np.array([[-0.25], [0.25]]), 1, 0.0)
    assert np.isnan(images[0, 0]) and images[1, 0] == pytest.approx(-0.3)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # what numba says of it
def test_a_piece_that_raises_has_no_value_there():
    def far(state, p):
        if state[0] > 0.9:
            raise ArithmeticError("too far")
        return (p.b * state[0],)

    P = gz.Map(pieces={"L": left, "R": far}, border=border, params=PARAMS, box=((-0.8, 0.8),))
    images, borders = P.images()(P.packed()[1][None], 0, np.array([[0.5], [0.95], [0.5], [0.95]]), 1, 0.0)
    assert images[::2, 0] == pytest.approx([0.35, 0.35]) and borders[::2, 0].tolist() == [0.5, 0.5]
    assert np.isnan(images[1::2]).all()


def test_a_border_that_is_not_a_number_ends_the_orbit():
    def lost(state, p):
        return state[0] if state[0] < 0.5 else (state[0] - state[0]) / (state[0] - state[0] + p.zero)

    if jit_disabled():
        pytest.skip("plain Python divides by zero with an exception")
    P = gz.Map(pieces=PIECES, border=lost, params=PARAMS | {"zero": 1.0}, box=((-1.0, 1.0),)).replace(zero=0.0)
    assert P.orbit((0.7,), 1).outcomes[0] & gz.Outcome.diverged


def wrong(message, error=gz.InputError, **changes):
    given = {"pieces": PIECES, "border": border, "params": PARAMS, "box": ((-1.0, 1.0),)} | changes
    with pytest.raises(error, match=message):
        gz.Map(**given)


def test_what_a_wrong_call_is_told():
    wrong("step is given with pieces", step=left)
    wrong("border is None; give border", border=None)
    wrong("border is given without pieces", pieces=None)
    wrong("step is missing", pieces=None, border=None)
    wrong("pieces is 5; give a function for each letter", pieces=5)
    wrong("pieces is {'L': 1", pieces={"L": 1, "R": right})
    for name in ("left", "1", "-", "", 0):
        wrong("is no letter for a piece", pieces={name: left, "R": right})
    wrong("pieces has 1 letter", pieces={"L": left})
    wrong("1 border.s. for 3 pieces .L, R, C.", pieces=PIECES | {"C": flat})
    wrong("1000000000000 border.s. for 2 pieces", border=range(10**12))
    wrong("letters is 'AB' for the pieces LR", letters="AB")
    wrong("needs two pieces", pieces=PIECES | {"C": lambda state, p, root: (root,)}, border=(border, upper))


def raising(state, p):
    raise ArithmeticError("too steep")


def test_pieces_and_borders_are_tried_where_they_hold():
    error = gz.UserCodeError
    wrong("piece R of map of pieces L, R raised ArithmeticError: too steep", error, pieces={"L": left, "R": raising})
    wrong(r"piece L of cut returned \(1.0, 2.0\)", error, pieces={"L": lambda s, p: (1.0, 2.0), "R": right}, name="cut")
    wrong("the letter is that of the piece", error, pieces={"L": lambda s, p: ((1.0,), 0), "R": right})
    wrong("the next state alone", error, pieces={"L": left, "R": lambda s, p: 1.0})
    wrong("the border of map of pieces L, R raised ArithmeticError", error, border=raising)
    for value in (float("nan"), np.zeros(1), (1.0,), True, None):
        wrong("allowed is one number", error, border=lambda s, p, value=value: value)
    # a piece whose side the box does not show may raise, but not return something else
    far = {"box": ((-2.0, -1.0),)}
    gz.Map(pieces={"L": left, "R": raising}, border=border, params=PARAMS, **far)
    wrong("piece R .* returned", error, pieces={"L": left, "R": lambda s, p: (1.0, 2.0)}, **far)


def test_a_word_with_an_unknown_letter():
    with pytest.raises(gz.InputError, match="allowed are L, R"):
        gz.periodic_orbits(LINES, word="LX")


def test_a_map_without_pieces_says_so():
    with pytest.raises(gz.InputError, match="has no pieces"):
        gz.Map(lambda s, p: (0.5 * s[0],), coordinates=("x",)).images()


def test_very_many_coordinates_are_not_listed():
    with pytest.raises(gz.InputError, match="coordinates"):
        gz.Map(lambda s, p: s, coordinates=range(10**12))
