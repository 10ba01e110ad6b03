"""A certificate is held against a model: all that both say of it, and nothing else."""

import pytest

import grazing as gz
from grazing.proof.gap import certify_gap_edge, certify_gap_orbit
from grazing.proof.gap_chaos import prove_no_attractor
from grazing.proof.same_model import of_rig, same_model
from tests.billiard.orbits import active_discs
from tests.grazing_checker.bases import table_bases
from tests.grazing_checker.documents import documents, own_model, rattle, vibrating_table

PINBALL = gz.pinball(d=0.12, V=0.4)
ACTIVE = gz.collision_map(active_discs(3.0)).origin.impacts_on


def same(document, model):
    assert gz.check_certificate(document, model=model) == document["statement"]


def another(document, model, said):
    with pytest.raises(gz.InputError, match=f"is right, but about another model: {said}"):
        gz.check_certificate(document, model=model)


def test_a_certificate_is_held_against_every_value_of_a_model():
    made = documents()
    same(made["stable"], PINBALL)
    same(made["own"], own_model())
    for name, value in PINBALL.params.items():
        known = {"d": "offset", "cos1": "cos 1", "sin1": "sin 1", "r": "law r", "V": "law V"}.get(name, name)
        another(made["stable"], PINBALL.replace(**{name: value + 1e-9}), f"its {known} is ")
    another(made["stable"], gz.pinball(d=0.12, V=0.4, r=0.5), "its law r is 0.8, here it is 0.5")
    another(made["stable"], rattle(), "its alpha is 3.0, here it is 0.1")


def test_a_name_of_the_constant_force_and_the_sign_of_a_zero_are_no_difference():
    """The same model was said to be another one, as its offset_name is d, here offset, or its sigma 0.0, here -0.0."""
    made = documents()
    force = gz.Forcing(omega=2.2, offset=0.12, cos=(1.0,))
    same(made["stable"], gz.Oscillator(alpha=3.0, k=1.0, forcing=force, sigma=-0.0, reset=gz.active(0.8, 0.4)))
    another(made["stable"], gz.Oscillator(3.0, 1.0, force, gz.active(0.8, 0.4), 1e-9), "its sigma is 0.0")


def test_the_parameter_that_is_enclosed_may_have_any_value_and_no_other():
    made = documents()
    same(made["pd"], PINBALL.replace(V=0.1))
    another(made["pd"], PINBALL.replace(d=0.1), "its offset is 0.12, here it is 0.1")
    table = vibrating_table(0.5, 1.4)
    same(made["table lp"], table.replace(**{"A.sin1": 0.7}))
    another(made["table pd"], table.replace(**{"A.sin1": 0.7}), "its walls A sin 1 is 1.4, here it is 0.7")


def test_walls_and_objects_are_compared_by_their_names():
    made = documents()
    same(made["rattle"], rattle())
    another(made["rattle"], rattle(sigma=0.25), "its walls B sigma is 0.5, here it is 0.25")
    kicked = table_bases()["kicked"]
    same(kicked, ACTIVE)
    another(kicked, active_discs(3.0, V=0.5), "its objects A law V is 0.25, here it is 0.5")
    another(kicked, active_discs(2.9), "its objects B shape x is 3.0, here it is 2.9")
    assert gz.check_certificate(kicked, law=lambda v, p: -p.r * v + p.V) == kicked["statement"]
    with pytest.raises(gz.InputError, match="about another law of A"):
        gz.check_certificate(kicked, law=lambda v, p: -v)


def test_of_the_gap_map_the_values_are_compared():
    orbit, (edge,) = certify_gap_orbit("R", 0.5, 0.9, 0.0).document, certify_gap_edge("LLR", "pd", 0.9, 0.0)
    same(orbit, gz.gap_map(lam=0.5, mu=0.9, l=0.0))
    another(orbit, gz.gap_map(lam=0.5, mu=0.8, l=0.0), "its mu is 0.9, here it is 0.8")
    same(edge.document, gz.gap_map(lam=0.9, mu=0.3, l=0.0))
    another(edge.document, gz.gap_map(lam=0.8, mu=0.3, l=0.0), "its lam is 0.9, here it is 0.8")
    with pytest.raises(gz.InputError, match=r"give a gz\.Oscillator, a gz\.table or a gap map"):
        gz.check_certificate(orbit, model=3)


def test_an_interval_of_the_gap_map_is_about_every_mu_in_it():
    proof = prove_no_attractor(0.9, 0.4, 0.28, 0.3).document
    for mu in (0.28, 0.29, 0.3):
        same(proof, gz.gap_map(lam=0.9, mu=mu, l=0.4))
    for mu in (0.27, 0.31):
        another(proof, gz.gap_map(lam=0.9, mu=mu, l=0.4), f"its mu is at least 0.28 and at most 0.3, here it is {mu}")
    another(proof, gz.gap_map(lam=0.8, mu=0.29, l=0.4), "its lam is 0.9, here it is 0.8")
    small = prove_no_attractor(0.9, 0.0, 0.0, 0.18).document
    same(small, gz.gap_map(lam=0.9, mu=1e-300, l=0.0))
    another(small, gz.gap_map(lam=0.9, mu=0.0, l=0.0), r"its mu is above 0\.0 and at most 0\.18, here it is 0\.0")


def constant(v, p):
    return p.after


def strange(v, p):
    return -p.model * v + p.parameters


@pytest.mark.parametrize(("law", "values"), [(constant, {"after": 0.5}), (strange, {"model": 0.3, "parameters": 0.4})])
def test_no_name_of_a_parameter_of_a_law_hides_its_value(law, values):
    """A law may call a parameter what certificates call their own parts."""

    def model(**changes):
        reset = gz.reset(law, **{**values, **changes})
        return gz.Oscillator(alpha=1.0, k=1.0, forcing=gz.Forcing(omega=2.2), reset=reset)

    data = of_rig(model(), [])
    same_model(data, model())
    for name, value in values.items():
        with pytest.raises(gz.InputError, match=f"another model: its law {name} is {value}, here it is 0.7"):
            same_model(data, model(**{name: 0.7}))
