import numpy as np
import pytest
from flint import arb, ctx

import grazing as gz
from grazing.oscillator.exact import Undecided
from grazing.oscillator.reset import fingerprint
from grazing.proof.checker_law import Jet, impact_of
from grazing.proof.checker_reading import Rejected
from grazing.proof.law import BreaksPromise, Law, NotInBalls
from tests.models import cubic


def strange(v, p):
    return abs(v) ** 3 * p.e - (p.c - v) / (2 + v**2) + 3 ** (-v) + (-v) ** p.e + (0.5 if v > -2.0 else 0.1 / -v)


LAWS = [
    gz.newton(r=0.7), gz.active(r=0.5, V=0.3), gz.triggered(r=0.6, V=0.5, trigger=0.4), gz.reset(cubic, e=0.9, c=0.5),
    gz.reset(strange, e=0.9, c=-1.5),
]  # fmt: skip


def balls(reset):
    return {name: arb(x) for name, x in reset.params.items()}


@pytest.mark.parametrize("reset", LAWS, ids=lambda reset: reset.name)
@pytest.mark.parametrize("v", [-0.31, -1.7, -2.5])
def test_slopes_are_exact_by_velocity_and_by_every_parameter(reset, v):
    with ctx.workprec(256):
        h = arb(2) ** -70
        for name in reset.params:
            p = balls(reset)
            w, slope, change = Law(reset, p, name)(arb(v))
            assert abs(float(w) - reset(v)) < 1e-14

            def at(velocity, value, p=p, name=name):
                return Law(reset, {**p, name: value}, name)(velocity)[0]

            assert abs((at(v + h, p[name]) - at(v - h, p[name])) / (2 * h) - slope) < 1e-35
            assert abs((at(arb(v), p[name] + h) - at(arb(v), p[name] - h)) / (2 * h) - change) < 1e-35
            code = "" if reset.name in ("newton", "active", "triggered") else fingerprint(reset)
            law = {"name": reset.name, "params": dict(reset.params), "code": code}
            other = impact_of(law, p, p, name, reset.law)(arb(v))
            assert other.w.overlaps(w)
            assert other.slope.overlaps(slope)
            assert other.change.overlaps(change)


@pytest.mark.parametrize("reset", LAWS, ids=lambda reset: reset.name)
def test_balls_hold_what_the_law_does_to_their_points(reset):
    rng = np.random.default_rng(2)
    v = arb(-0.9, 1e-3)
    w, slope, _change = Law(reset, balls(reset))(v)
    for s in rng.uniform(-1e-3, 1e-3, 20):
        thin, steep, _ = Law(reset, balls(reset))(arb(-0.9) + arb(float(s)))
        assert w.contains(thin)
        assert slope.contains(steep)


def test_a_jump_of_the_law_inside_the_ball_is_undecided():
    reset = gz.triggered(r=0.6, V=0.5, trigger=0.4)
    with pytest.raises(Undecided):
        Law(reset, balls(reset))(arb(-0.4, 1e-9))
    impact = impact_of({"name": "triggered", "params": {}, "code": ""}, balls(reset), balls(reset), "", None)
    with pytest.raises(Rejected, match="not certain whether an impact fires"):
        impact(arb(-0.4, 1e-9))


def rooted(v, p):
    from math import sqrt

    return sqrt(-v)


def never(v, p):
    return float("inf") if isinstance(v, float) is False else 1.0


def test_a_law_that_balls_cannot_take_is_refused_by_name():
    with pytest.raises(NotInBalls, match="TypeError"):
        Law(gz.reset(rooted), {"a": arb(0)})(arb(-0.5))
    with pytest.raises(BreaksPromise):
        Law(gz.reset(never), {"a": arb(0)})(arb(-0.5))
    law = {"name": "rooted", "params": {}, "code": fingerprint(gz.reset(rooted))}
    with pytest.raises(Rejected, match="cannot be evaluated in balls"):
        impact_of(law, {}, {"a": arb(0)}, "", rooted)(arb(-0.5))


def test_the_checker_asks_for_the_law_and_knows_it_by_its_code():
    reset = gz.reset(cubic, e=0.9, c=0.5)
    law = {"name": "cubic", "params": dict(reset.params), "code": fingerprint(reset)}
    for code, said in ((None, "give it too"), (strange, "is not the reset law"), (3, "give it too")):
        with pytest.raises(Rejected, match=said):
            impact_of(law, balls(reset), balls(reset), "", code)


@pytest.mark.parametrize(
    ("name", "params"), [("newton", {"r": 0.5, "V": 1.0}), ("cubic", {"r": 0.5}), ("newton", {"r": 1.5})]
)
def test_the_checker_knows_its_own_laws_only_as_they_are(name, params):
    with pytest.raises(Rejected):
        impact_of({"name": name, "params": params, "code": ""}, {k: arb(x) for k, x in params.items()}, {}, "", None)


def test_jets_refuse_what_is_no_number():
    for wrong in (True, "1", None):
        with pytest.raises(TypeError):
            Jet.of(wrong)
