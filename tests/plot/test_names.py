"""Names and letters that somebody chose are drawn as they are: no figure breaks on what mathematics cannot read."""

import itertools
import warnings

import matplotlib.pyplot as plt
import numpy as np
import pytest

import grazing as gz
from grazing.plot.classes import class_name, written
from grazing.plot.style import drawable, label, mathematics, plain

AWKWARD = ("$", "$$", "_", "__", "^", "{", "}", "%", "#", "&", "\\", r"\frac{", r"$\frac{", "a_b_c", "a_", "x^y^z", "µ")


def tent(state, p):
    (x,) = state
    if x < 0.0:
        return (p.a_b_c * x + p.mu_,), 0
    return (-0.6 * x + p.mu_,), 1


def drawn(texts):
    """Draw texts as entries of a legend; return those that it shows."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure, ax = plt.subplots(figsize=(1, 1), dpi=40)
        legend = ax.legend(handles=[plt.Line2D([], [], label=text) for text in texts])
        shown = [entry.get_text() for entry in legend.get_texts()]
        figure.canvas.draw()
        plt.close(figure)
    return shown


@pytest.mark.filterwarnings("ignore:Glyph")
def test_whatever_somebody_calls_a_thing_is_drawn():
    names = [*AWKWARD, *("".join(pair) for pair in itertools.product("$_{", "^}a"))]
    texts = [label(name, name) for name in names] + [plain(name) for name in names]
    texts += [drawable(name) for name in names] + [drawable("f = $" + name + "$") for name in names]
    words = [a + b for a, b in itertools.product(r"$_^{}\%#L", repeat=2)] + [a * 7 + "$_" for a in r"$_^{}\%#L"]
    texts += [written(word) for word in words] + [class_name(word * 9, 3) for word in words]
    texts = list(dict.fromkeys(texts))
    assert drawn(texts) == texts


def test_good_mathematics_stays_mathematics():
    assert label("omega", r"\omega") == r"$\omega$" and label("my", r"\mathrm{my}") == r"$\mathrm{my}$"
    assert mathematics("x_{n+1}", "x") == "$x_{n+1}$"
    assert drawable(r"where $\mu = 1$") == r"where $\mu = 1$"
    assert mathematics("a_b_c", "a_b_c") == "a_b_c" and plain("US$ and $") == r"US\$ and \$"
    assert written("LLR") == "LLR" and written("LLLLLR") == r"$\mathrm{L}^{5}\mathrm{R}$"


@pytest.mark.parametrize("coordinate", ["x", "%", "{", "$"])
def test_figures_of_a_map_with_awkward_names(coordinate):
    P = gz.Map(
        tent,
        params={"a_b_c": 0.5, "mu_": -0.2},
        box=((-1.0, 1.0),),
        letters="$_",
        coordinates=(coordinate,),
        name="$_$",
    )
    values = np.linspace(-0.3, 0.3, 3)
    (orbit,) = gz.periodic_orbits(P, 1)
    results = {
        "orbit_diagram": gz.orbit_diagram(P, "mu_", values, starts=2, transient=20, keep=8),
        "chart": gz.chart(P, {"mu_": values, "a_b_c": values}),
        "basins": gz.basins(P, {coordinate: np.linspace(-1.0, 1.0, 9)}),
        "coexistence": gz.coexistence(P, "mu_", values, starts=3),
        "lyapunov": gz.lyapunov(P, "mu_", values, starts=1),
        "graph": gz.graph(P, coordinate, np.linspace(-1.0, 1.0, 9)),
        "branch": gz.continuation(P, orbit, "mu_", (-0.5, 0.5)),
    }
    for name, result in results.items():
        getattr(gz.plot, name)(result)
        plt.gcf().canvas.draw()
        plt.close("all")


def test_a_law_of_ones_own_with_a_long_name():
    model = gz.Oscillator(
        alpha=1.0,
        k=1.0,
        forcing=gz.Forcing(omega=2.2),
        reset=gz.reset(lambda v, p: -p.rest_of_it_ * v, rest_of_it_=0.5),
    )
    symbol = gz.stroboscopic_map(model).describe("rest_of_it_").symbol
    assert drawn([label("rest_of_it_", symbol)])
