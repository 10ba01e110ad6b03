"""Derivatives of edges: against identities that hold for every model, closed forms, and differences of the windows."""

import re

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.orbits.sensitivity import Edge, sensitivity
from grazing.orbits.survey import families
from grazing.orbits.windows import windows
from tests.models import MODELS
from tests.orbits.test_exact_edges import N as PERIODS
from tests.orbits.test_exact_edges import newton, orbit
from tests.orbits.test_windows import TYPED

SMALL = 1e-9


def edges_of(found):
    """Every edge: its window's row, its type, its value, and the derivatives and errors by parameter."""
    for w in range(found.sizes["window"]):
        for e in (0, 1):
            names = found.parameter.values.tolist()
            slopes = dict(zip(names, found.derivative.values[w, e].tolist(), strict=True))
            errors = dict(zip(names, found.error.values[w, e].tolist(), strict=True))
            yield w, str(found.type.values[w, e]), float(found.value[w, e]), slopes, errors


def degrees(name):
    """How a parameter scales with length and with the inverse of time."""
    if name in ("d", "offset") or name[:3] in ("cos", "sin"):
        return 1, 2
    return {"sigma": (1, 0), "V": (1, 1), "trigger": (1, 1), "t0": (0, -1)}.get(
        name, (0, 1) if name in ("alpha", "k", "omega") else (0, 0)
    )


def identities(model, name, value, slopes):
    """Defects of five identities, each in parts of its largest term.

    Other units of length or of time change no window (Euler's theorem on homogeneous functions). Neither does a wall
    moved by ds with the offset changed by -k^2 ds, nor the origin of time, nor a phase that turns every harmonic.
    """
    here = {**model.params, name: value}
    offset = model.offset_name
    # an edge F(p, q) = 0 in the parameter p moves by -(dF/dq) / (dF/dp): with -1 for p itself all are in proportion
    tangent = {**slopes, name: -1.0}
    scales = [degrees(q) for q in here]
    sums = [[here[q] * by[i] * tangent[q] for q, by in zip(here, scales, strict=True)] for i in (0, 1)]
    sums.append([tangent["sigma"], here["k"] ** 2 * tangent[offset]])
    sums.append([tangent["t0"]])
    turned = []
    for j in range(1, model.harmonics + 1):
        turned += [j * here[f"sin{j}"] * tangent[f"cos{j}"], -j * here[f"cos{j}"] * tangent[f"sin{j}"]]
    sums.append(turned)
    floor = max(abs(slope) for slope in tangent.values())
    return [abs(sum(terms)) / max(floor, *(abs(term) for term in terms)) for terms in sums]


@pytest.mark.parametrize("tag", [tag for tag in MODELS if tag != "own law"])
def test_edges_obey_the_symmetries_of_the_model(tag):
    model = MODELS[tag]
    seen = 0
    for name in (model.offset_name, "omega", [*model.params][-1]):
        found = sensitivity(model, name, [1, 2], samples=100)
        for _w, kind, value, slopes, errors in edges_of(found):
            if kind == "end":
                assert np.isnan(list(slopes.values())).all() and np.isnan(list(errors.values())).all()
                continue
            assert slopes[name] == 0.0
            assert max(identities(model, name, value, slopes)) < SMALL
            assert max(errors.values()) < 1e-8 * max(1.0, *(abs(slope) for slope in slopes.values()))
            seen += 1
    assert seen > 0 or tag in ("stiff", "chatter", "slow")


@pytest.mark.parametrize("tag", TYPED)
def test_every_type_of_edge_has_derivatives(tag):
    model, name, N, span, types = TYPED[tag]
    found = sensitivity(model, name, N, span)
    assert " ".join(kind for _w, kind, *_ in edges_of(found)) == re.sub(r"gr\d", "gr", types)
    for _w, kind, value, slopes, _errors in edges_of(found):
        if kind == "end" or abs(value) < 1e-30:  # where all forces vanish the phase does, too
            assert np.isnan(list(slopes.values())).all()
        else:
            assert max(identities(model, name, value, slopes)) < 1e-7


def shifted(model, parameter, h, name, N, near, kind, reach):
    """The edge of one type next to a value after a change of one parameter, by a search of its own."""
    other = model.replace(**{parameter: model.params[parameter] + h})
    table = windows(other, name, N, (near - reach, near + reach), 40)
    edges = [
        float(table[side][w])
        for w in range(table.sizes["window"])
        for side in ("low", "high")
        if table[f"{side}_type"].values[w] == kind
    ]
    return min(edges, key=lambda edge: abs(edge - near))


LIGHT = gz.pinball(alpha=0.1, omega=3.27, d=0.57, r=0.9, V=0.1)


@pytest.mark.parametrize(
    "model, name, N, samples",
    [(gz.pinball(), "d", 3, 200), (LIGHT, "d", 2, 200), (MODELS["two harmonics"], "offset", 1, 200)],
)  # fmt: skip
def test_derivatives_are_those_of_the_windows(model, name, N, samples):
    seen = 0
    for _w, kind, value, slopes, _errors in edges_of(sensitivity(model, name, N, samples=samples)):
        if kind == "end":
            continue
        model_there = model.replace(**{name: value})
        for parameter, slope in slopes.items():
            if parameter == name:
                continue
            h = 2e-5 * max(1.0, abs(model.params[parameter]))
            reach = 1e-3 + 8.0 * h * abs(slope)
            near, far = (
                [shifted(model_there, parameter, s * k * h, name, N, value, kind, reach) for s in (1, -1)]
                for k in (1, 2)
            )
            difference = (8.0 * (near[0] - near[1]) - (far[0] - far[1])) / (12.0 * h)
            assert slope == pytest.approx(difference, rel=1e-6, abs=3e-8), (kind, parameter)
            seen += 1
    assert seen > 0


def test_the_graze_of_long_windows_follows_that_of_the_steady_response():
    """As N grows both edges come to the graze d = k^2 a of the response without impact, and so do their derivatives."""
    model = gz.pinball()
    found = sensitivity(model, "d", [5, 7, 9], (0.127, 0.1309618))

    def graze(alpha, k, omega, cos1, sigma):
        return k**2 * (cos1 / abs(complex(k**2 - omega**2, alpha * omega)) + sigma)

    at = {q: model.params[q] for q in ("alpha", "k", "omega", "cos1", "sigma")}
    exact = {}
    for q in at:
        h = 1e-4
        exact[q] = (graze(**{**at, q: at[q] + h}) - graze(**{**at, q: at[q] - h})) / (2 * h)
    away = []
    for w in range(found.sizes["window"]):
        for e in (0, 1):
            got = found.derivative[w, e]
            away.append(max(abs(float(got.sel(parameter=q)) - exact[q]) for q in exact))
            assert abs(float(got.sel(parameter="sigma")) - 1.0) < 1e-10
    assert found.N.values.tolist() == [5, 7, 9] and away[0] > 4 * away[2] > 16 * away[4] > 0
    assert away[5] < 3e-4
    # impacts do not matter in the limit
    for q in ("r", "V"):
        size = np.abs(found.derivative.sel(parameter=q).values)
        assert (size[1:] < 0.3 * size[:-1]).all()


def test_signs():
    """A stronger kick, or a livelier ball, widens no window beyond what lifts it: both edges of N = 3 fall in d."""
    found = sensitivity(gz.pinball(), "d", 3)
    for q, sign in (("V", -1), ("r", -1), ("cos1", 1), ("alpha", -1), ("sigma", 1)):
        assert (np.sign(found.derivative.sel(parameter=q).values) == sign).all()


def test_the_table():
    model = gz.pinball()
    found, table = sensitivity(model, "d", [2, 3]), windows(model, "d", [2, 3])
    assert found.derivative.dims == ("window", "edge", "parameter")
    assert found.parameter.values.tolist() == list(model.params) and found.edge.values.tolist() == ["low", "high"]
    for e, side in enumerate(("low", "high")):
        assert np.array_equal(found.value.values[:, e], table[side].values)
        assert found.type.values[:, e].tolist() == table[f"{side}_type"].values.tolist()
    assert found.attrs["parameter"] == "d"


def test_one_edge_knows_the_other_way_round():
    """The derivative of d in V and that of V in d, at one and the same edge, are inverse to each other."""
    there = float(windows(gz.pinball(), "d", 3).high[0])
    one = sensitivity(gz.pinball(), "d", 3)
    other = sensitivity(gz.pinball(d=there), "V", 3)
    [(w, e)] = np.argwhere(np.abs(other.value.values - 0.4) < 1e-9).tolist()
    a = float(one.derivative.sel(window=0, edge="high", parameter="V"))
    b = float(other.derivative[w, e].sel(parameter="d"))
    assert a * b == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("q", ["alpha", "k", "omega", "r", "V"])
def test_errors_are_no_smaller_than_what_is_missed(q):
    """Against differences in 50 digits of a period doubling that another closed form gives."""
    model = gz.pinball(r=0.45)
    found = sensitivity(model, "omega" if q != "omega" else "d", PERIODS, samples=200).sel(window=0)
    edge = str(found.edge.values[found.type.values.tolist().index("pd")])
    table = windows(model, found.attrs["parameter"], PERIODS, samples=200).isel(window=0)
    phase, value = float(table[f"{edge}_phase"]), float(table[edge])
    with mp.workdps(50):

        def doubling(change):
            here = {name: mp.mpf(x) for name, x in model.params.items()}
            here[q] += change

            def f(phi, p):
                at = {**here, found.attrs["parameter"]: p}
                G, v, trace, det = orbit(phi, at["d"], at, at["V"])
                return G, v * (1 + trace + det)

            return newton(f, (phase, value))[1]

        h = mp.mpf(10) ** -12
        true = (doubling(h) - doubling(-h)) / (2 * h)
        missed = abs(float(true - mp.mpf(float(found.derivative.sel(edge=edge, parameter=q)))))
    error = float(found.error.sel(edge=edge, parameter=q))
    assert missed <= error < 1e-10 * (1.0 + abs(float(true)))


def test_no_unit_matters():
    """Lengths 2^4 times as large and times 2^12: derivatives were off by 1e3, beyond their errors."""
    alpha, k, omega, d = 3.1337865890975474, 1.1611922187733168, 1.2989572466333672, 0.13593608661306172

    def model(length, time):
        force = length / time**2
        forcing = gz.Forcing(omega=omega / time, offset=d * force, cos=(force,))
        law = gz.triggered(r=0.919187898419003, V=0.0, trigger=0.1 * length / time)
        return gz.Oscillator(alpha=alpha / time, k=k / time, forcing=forcing, reset=law)

    far = 2.0**4, 2.0**12
    one, other = (sensitivity(model(*units), "omega", 1) for units in ((1.0, 1.0), far))
    units = [far[0] ** length * far[1] ** -rate for length, rate in map(degrees, one.parameter.values.tolist())]
    moved, error = (table.values * units * far[1] for table in (other.derivative, other.error))
    assert one.sizes == other.sizes and one.sizes["window"] > 0
    assert (np.abs(one.derivative.values - moved) <= one.error.values + error).all()


def test_a_harmonic_that_is_not_there_yet():
    """The fastest harmonic weighs the test functions, and jumps at an amplitude of 0: slopes were wrong there."""

    def model(cos2):
        push = gz.Forcing(3.0, offset=0.4, cos=(1.2, cos2), sin=(-0.2,))
        return gz.Oscillator(0.0, 2.4, push, gz.newton(0.45), -0.34)

    found, here = sensitivity(model(0.0), "omega", 1).sel(parameter="cos2"), 1e-3
    one, other = (windows(model(cos2), "omega", 1) for cos2 in (-here, here))
    assert found.sizes["window"] > 1 and (found.error < 1e-10).all()
    for edge in ("low", "high"):
        true = (other[edge].values - one[edge].values) / (2.0 * here)
        assert np.allclose(found.derivative.sel(edge=edge).values, true, atol=2e-5)


def test_bad_input():
    with pytest.raises(gz.InputError, match="unknown parameter 'D'"):
        sensitivity(gz.pinball(), "D")
    with pytest.raises(gz.OutsideForm, match="affine"):
        sensitivity(MODELS["own law"], "omega", 1)


def test_an_edge_at_which_there_is_no_orbit_has_no_derivatives():
    model = gz.pinball(V=0.4, d=1000.0)  # the force never brings the ball back
    (family,) = families(model, 1, "d")
    assert Edge(family, "pd", 1000.0, 0).moved(1e-6) is None
