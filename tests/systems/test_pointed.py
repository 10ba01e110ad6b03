"""Systems by address: the same bits as the functions themselves, compiled or in plain Python."""

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import address, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import replaced
from grazing.parameter import parameters
from grazing.systems.contact import Asked, asked_of
from grazing.systems.pointed import Place, _address, place_of, pointed_of
from tests.systems.models import oscillator

SYSTEM = oscillator(walls=2)[0]
ONE, P = asked_of(SYSTEM.period, *SYSTEM.parts), parameters(SYSTEM.params)
ARGS = {
    "flight": (0.7, 0.2, (0.1, 0.3)),
    "gap": (1, 0.7, (0.1, 0.3)),
    "bound": (1, 0.7, 0.1, (0.1, 0.3)),
    "law": (1, 0.7, (0.3, 0.4)),
    "period": (),
}
#: To one wall, to none, and away from one to the other.
FLIGHTS = [(0.2, (0.1, 0.3), 9.0, -1.0), (0.2, (0.1, 0.3), 0.3, -1.0), (0.2, (0.3, -0.4), 9.0, 1.0)]


def same(a, b):
    """Say whether two answers are the same numbers, NaN included, however their tuples are nested."""
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(*pair) for pair in zip(a, b, strict=True))
    return a == b or (a != a and b != b)


def asked_by_address(asked):
    """Return functions that ask a system by its address, compiled in one."""
    (flight, gap, bound, law, contact, period), unpack = asked, unpacker(Place)

    def all_of_it(place, t0, x, v, end, left):
        p, state = unpack(place), replaced(replaced((0.0, 0.0), 0, x), 1, v)
        said = contact(t0, state, end, left, p)
        others = flight(0.7, t0, state, p), gap(1, 0.7, state, p), bound(1, 0.7, 0.1, state, p)
        return said, *others, law(1, 0.7, state, p), period(p)

    return all_of_it


@pytest.mark.parametrize(("flight", "wall"), [*zip(FLIGHTS, (1, -1, 0), strict=True)])
def test_a_system_by_its_address_is_the_system(flight, wall):
    t0, state, end, left = flight
    place, _source = place_of(SYSTEM)
    found = compiled(asked_by_address(pointed_of(1)))(place, t0, *state, end, left)
    assert same(found[0], ONE.contact(*flight, P)) and found[0][0] == wall
    others = ONE.flight(0.7, t0, state, P), ONE.gap(1, 0.7, state, P), ONE.bound(1, 0.7, 0.1, state, P)
    assert same(found[1:], (*others, ONE.law(1, 0.7, state, P), ONE.period(P)))


def test_in_plain_python_an_address_is_a_place_in_a_list(monkeypatch):
    with monkeypatch.context() as patch:
        patch.setenv("NUMBA_DISABLE_JIT", "1")
        patch.setattr("grazing.systems.pointed.address", address.__wrapped__)
        patch.setattr("grazing.systems.pointed._address", _address.__wrapped__)
        place, _source = place_of(SYSTEM.replace(**{"B.sigma": 0.25}))
    pointed = pointed_of(1)
    p, q = Place(*place.tolist()), parameters(SYSTEM.replace(**{"B.sigma": 0.25}).params)
    for flight in FLIGHTS:
        assert same(pointed.contact(*flight, p), ONE.contact(*flight, q))
    for name, args in ARGS.items():
        assert same(getattr(pointed, name)(*args, p), getattr(ONE, name)(*args, q)), name
    assert {*ARGS, "contact"} == {*Asked._fields}


def test_one_code_serves_all_values_and_the_map_as_well():
    place, source = place_of(SYSTEM)
    other, moved = place_of(SYSTEM.replace(**{"A.r": 0.5}))
    assert place[0] == other[0] and place[1] == source.ctypes.data != other[1] and not np.array_equal(source, moved)
    Q = gz.stroboscopic_map(SYSTEM, phase=0.3)
    rows = np.array([Q.packed()[1], Q.replace(**{"A.r": 0.5}).packed()[1]])
    table = Q.origin.derivative(rows).rows
    assert table[0, 0] == place[0] and np.array_equal(table[:, -rows.shape[1] :], rows)
    whole = Q.run_columns(rows, np.array([[[0.1], [0.3]]] * 2), 0, 20, arithmetic="strict")
    one, two = (Q.replace(**{"A.r": r}).iterate((0.1, 0.3), 20)[1:] for r in (0.8, 0.5))
    assert np.array_equal(whole.points[0, :, :, 0], one) and np.array_equal(whole.points[1, :, :, 0], two)
    assert not np.array_equal(one, two)


def test_a_system_is_compiled_once_for_both_arithmetics():
    P = gz.stroboscopic_map(SYSTEM)
    rows = np.array([list(P.params.values())])
    _address.cache_clear()
    code = {P.origin.derivative(rows, arithmetic).rows[0, 0] for arithmetic in ("fast", "strict")}
    assert code == {place_of(SYSTEM)[0][0]} and _address.cache_info().misses == 1
