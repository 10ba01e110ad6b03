import pytest
from flint import arb, ctx

import grazing as gz
from grazing.oscillator.sure import Undecided
from grazing.proof.expression import expression
from grazing.proof.law import Law
from tests.models import cubic
from tests.proof.test_expression import strange

LAWS = [
    gz.newton(r=0.7), gz.active(r=0.5, V=0.3), gz.triggered(r=0.6, V=0.5, trigger=0.4), gz.reset(cubic, e=0.9, c=0.5),
    gz.reset(strange, e=0.9, c=-1.5),
]  # fmt: skip


def law_of(reset, name=None, **changes):
    params = {key: arb(x) for key, x in reset.params.items()}
    return Law(expression(reset.law, reset.params, tuple(reset.params)), params | changes, name)


@pytest.mark.parametrize("reset", LAWS, ids=lambda reset: reset.name)
@pytest.mark.parametrize("v", [-0.31, -1.7, -2.5])
def test_slopes_are_exact_by_velocity_and_by_every_parameter(reset, v):
    with ctx.workprec(256):
        h = arb(2) ** -70
        for name, x in reset.params.items():
            w, slope, change = law_of(reset, name)(arb(v))
            assert abs(float(w) - reset(v)) < 1e-14

            def at(velocity, value, name=name):
                return law_of(reset, None, **{name: value})(velocity)[0]

            assert abs((at(v + h, arb(x)) - at(v - h, arb(x))) / (2 * h) - slope) < 1e-35
            assert abs((at(arb(v), x + h) - at(arb(v), x - h)) / (2 * h) - change) < 1e-35


def test_a_jump_of_the_law_inside_the_ball_is_undecided():
    with pytest.raises(Undecided):
        law_of(gz.triggered(r=0.6, V=0.5, trigger=0.4))(arb(-0.4, 1e-9))


def test_a_law_that_is_not_finite_is_undecided():
    with pytest.raises(Undecided):
        law_of(gz.reset(lambda v, p: 1 / (v + 0.75) ** 2, a=1.0))(arb(-0.75, 1e-9))
