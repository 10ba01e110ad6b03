"""Forged certificates: false data, with everything that the checker can make from them made to fit.

A forger changes the data by algebra (signs, ranks, roles, indices, moduli, a neighbour's numbers), then lets the
checker's own code write the inequalities, the claims and the statement, and seals the whole anew. So nothing but the
mathematics stands against him.
"""

import random
from contextlib import contextmanager
from copy import deepcopy
from functools import partial
from math import inf, isfinite, nextafter, ulp

import numpy as np

from grazing.proof.report import bound
from grazing.proof.text import below, enclosed
from grazing_checker import gap, orbit, plane, table, table_value, value
from grazing_checker.balls import LOCK, double, number, pi, precision
from grazing_checker.check import KINDS, trusted_base
from grazing_checker.envelope import seal
from grazing_checker.gradient import Gradient
from grazing_checker.oscillator import Problem
from grazing_checker.reading import decimal, exact
from grazing_checker.sentence import orbit_sentence, value_sentence

SENTENCES = {
    "periodic orbit": orbit_sentence,
    "periodic orbit with walls": orbit_sentence,
    "periodic orbit on a table": table.table_sentence,
    "bifurcation value": value_sentence,
    "bifurcation value with walls": value_sentence,
    "bifurcation value on a table": table_value.table_value_sentence,
    "gap map orbit": gap.orbit_sentence,
    "gap map edge": gap.edge_sentence,
    "gap map without attracting orbits": gap.no_attractor_sentence,
}


class Pen:
    """Stands in the place of the checker's Inequalities, and writes down what would hold, if anything does."""

    script = ()

    def __init__(self, _rows):
        self.rows = []

    @property
    def name(self):
        """What the true certificate says here: the forger follows it where the checker asks what comes next.

        That is what comes there behind the last row that both have: there may be more of these than in the true one.
        """
        names = [one["name"] for one in self.script]
        known = [names.index(one["name"]) for one in self.rows if one["name"] in names]
        return next(iter(names[known[-1] + 1 if known else 0 :]), "")

    def more(self, name, x):
        self.rows.append(bound(name, x, ">", 0) if x.is_finite() else row(name, ">", "0"))

    def less(self, name, x, right="0"):
        limit = exact(right) if "x" in right else int(right)
        self.rows.append(bound(name, x, "<", limit) if x.is_finite() else row(name, "<", right))

    def left(self, name, relation, right="0"):
        """A limit that something is held against: that of the true certificate, or hardly any."""
        least = {">": "1E-90", "<": "-1E-90" if right == "0" else "0.99999999"}[relation]
        known = [one["left"] for one in self.script if one["name"] == name]
        self.rows.append(row(name, relation, right, known[0] if known else least))
        return decimal(self.rows[-1]["left"])

    def finish(self):
        raise Written(self.rows)


class Written(Exception):
    """The checker's own code has come to its last inequality."""


def row(name, relation, right, left="0"):
    return {"name": name, "left": left, "relation": relation, "right": right}


@contextmanager
def forging(script, honest):
    """Let the checker write inequalities, and claims as well if they are to fit."""

    def write(x, texts, _where):
        if x.is_finite():
            texts[:] = enclosed(x)

    kept = {
        (module, name): getattr(module, name)
        for module in (gap, orbit, table, table_value, value)
        for name in ("Inequalities", "within")
    }
    pen = type("Pen", (Pen,), {"script": script})
    try:
        for module, name in kept:
            if name == "Inequalities":
                setattr(module, name, pen)
            elif honest:
                setattr(module, name, write)
        yield
    finally:
        for (module, name), thing in kept.items():
            setattr(module, name, thing)


def sealed(kind, data, script, honest=True):
    """Return data as a certificate, with the inequalities, claims and sentence that the checker makes of them."""
    data = deepcopy(data)
    rows = list(script)
    with LOCK, forging(script, honest):
        try:
            KINDS[kind].check(data, [])
        except Written as done:
            rows = done.args[0]
        except Exception:  # the checker stops before the end: the true certificate's inequalities stay
            pass
    try:
        said = SENTENCES[kind](data)
    except Exception:
        said = "The forged statement cannot be read."
    return seal(kind, said, trusted_base(kind), data, rows)


# What a forger does to numbers


def is_exact(text):
    return isinstance(text, str) and text.lstrip("-").startswith("0x") and "." not in text


def is_double(text):
    return isinstance(text, str) and text.lstrip("-").startswith("0x") and "." in text


def is_decimal(text):
    return isinstance(text, str) and text.lstrip("-")[:1].isdigit() and not text.lstrip("-").startswith("0x")


def other_exact(rng, text):
    """Another exact number: of the other sign, zero, scaled, or nearby."""
    mantissa, exponent = text.split("p")
    m, e = int(mantissa, 16), int(exponent)
    shift = rng.choice((-200, -60, -7, -1, 1, 3, 40, 3000))
    return rng.choice(
        (
            f"{-m:#x}p{e}",
            "0x0p0",
            f"{m:#x}p{e + shift}",
            f"{(m << 70) + rng.randint(-9, 9):#x}p{e - 70}",
            f"{(m << 20) + rng.randint(-(2**19), 2**19):#x}p{e - 20}",
            f"{-m:#x}p{e + shift}",
        )
    )


def other_double(rng, text):
    x = float.fromhex(text)
    new = rng.choice(
        (
            -x,
            0.0,
            2 * x,
            x / 2,
            x + 1.0,
            1.0 - x,
            nextafter(x, inf),
            nextafter(x, -inf),
            x * 1.001,
            x + 1e-9,
            1e300,
            5e-324,
        )
    )
    return new.hex() if isfinite(new) else "nan"


def other_decimal(rng, text):
    x = float(text)
    longer = text + "9" if "E" not in text else text
    new = (str(-x), "0", str(2 * x), str(x + 1.0), longer, f"{x + ulp(x):.17g}", str(x * 1.01))
    return rng.choice(new).upper().replace("E+", "E")


def leaves(value, path=()):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*path, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from leaves(inner, (*path, i))
    else:
        yield path


def at(data, path):
    for step in path:
        data = data[step]
    return data


def put(data, path, value):
    at(data, path[:-1])[path[-1]] = value


# What a forger does to a certificate; each changes the data and says nothing


def one_number(rng, data, _others):
    """Any number: sign, zero, scale."""
    path = rng.choice(list(leaves(data)))
    text = at(data, path)
    if is_double(text):
        put(data, path, other_double(rng, text))
    elif is_exact(text):
        put(data, path, other_exact(rng, text))
    elif is_decimal(text):
        put(data, path, other_decimal(rng, text))
    elif isinstance(text, bool):
        put(data, path, not text)
    elif isinstance(text, int):
        put(data, path, text + rng.choice((-2, -1, 1, 2, 5)))


def radii(rng, data, _others):
    """Negative, zero, huge or swapped half-widths."""
    names = [name for name in ("radius", "unique") if name in data]
    if len(names) == 2 and rng.random() < 0.3:
        data["radius"], data["unique"] = data["unique"], data["radius"]
        return
    name = rng.choice(names or ["radius"])
    how = rng.choice(("minus", "zero", "any", "equal"))

    def new(text):
        m, e = text.split("p")
        return {"minus": f"{-int(m, 16):#x}p{e}", "zero": "0x0p0", "equal": "0x1p-60"}.get(how) or other_exact(
            rng, text
        )

    for one in names if rng.random() < 0.5 else [name]:
        data[one] = [new(x) for x in data[one]] if isinstance(data[one], list) else new(data[one])


def matrix(rng, data, _others):
    """A preconditioner that is none: zero, of low rank, scaled, permuted, of another size."""
    rows = data["preconditioner"]
    n = len(rows)
    how = rng.randrange(11)
    factor = rng.choice((-1.0, 0.5, 2.0, 1e9, -1e-9, 1.0000001))
    scaled = [[(float.fromhex(x) * factor).hex() for x in one] for one in rows]
    i, j = rng.randrange(n), rng.randrange(n)
    if how == 0:
        rows = [["0x0.0p+0"] * n for _ in rows]
    elif how == 1:
        rows = [rows[i]] * n
    elif how == 2:
        rows = [[one[j]] * n for one in rows]
    elif how == 3:
        rows = scaled
    elif how == 4:
        rows = [scaled[k] if k == i else one for k, one in enumerate(rows)]
    elif how == 5:
        rows = rng.sample(rows, n)
    elif how == 6:
        order = rng.sample(range(n), n)
        rows = [[one[k] for k in order] for one in rows]
    elif how == 7:
        rows = [list(one) for one in zip(*rows, strict=True)]
    elif how == 8:
        rows = rows[:-1]
    elif how == 9:
        rows = [[*one, "0x0.0p+0"] for one in rows]
    else:
        rows = [[(float(i == k)).hex() for k in range(n)] for i in range(n)]
    data["preconditioner"] = rows


def of_a_neighbour(rng, data, others):
    """Parts of another true certificate of the same kind."""
    other = rng.choice(others)
    for name in rng.sample(sorted(data), rng.randint(1, 3)):
        if name in other:
            data[name] = deepcopy(other[name])


def neighbours_proof(rng, data, others):
    """The whole proof of a neighbour about the model of this one."""
    other = rng.choice(others)
    keep = {"lam", "mu", "l", "model", "law", "walls", "word", "low", "high", "objects", "rho", "g", "tilt"}
    for name in data:
        if name not in keep and name in other:
            data[name] = deepcopy(other[name])


def roles(rng, data, _others):
    """Two fields, or two entries of a list, in each other's place."""
    lists = [path for path in inner_lists(data) if len(at(data, path)) > 1]
    if lists and rng.random() < 0.7:
        one = at(data, rng.choice(lists))
        i, j = rng.sample(range(len(one)), 2)
        one[i], one[j] = one[j], one[i]
        return
    a, b = rng.sample(sorted(data), 2)
    data[a], data[b] = data[b], data[a]


def inner_lists(value, path=()):
    if isinstance(value, list):
        yield path
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from inner_lists(inner, (*path, key))


def dropped(rng, data, _others):
    """An entry of a list, or a field, is left out, or written twice."""
    lists = [path for path in inner_lists(data) if at(data, path)]
    one = at(data, rng.choice(lists))
    i = rng.randrange(len(one))
    if rng.random() < 0.5:
        del one[i]
    else:
        one.insert(i, deepcopy(one[i]))


def parameter(rng, data, _others):
    """Another value of a parameter of the model."""
    if "objects" in data:
        places = [(data, name) for name in ("rho", "g", "tilt", "energy")]
        places += [(one["shape"], name) for one in data["objects"] for name in one["shape"]]
        places += [(law["parameters"], name) for law in laws_in(data) for name in law["parameters"]]
    elif "model" in data:
        parts = [data["model"], *data.get("walls", ())]
        places = [(part, name) for part in parts for name, text in part.items() if text is None or is_double(text)]
        places += [(part[row], j) for part in parts for row in ("cos", "sin") for j in range(len(part[row]))]
        places += [(law["parameters"], name) for law in laws_in(data) for name in law["parameters"]]
    else:
        places = [(data, name) for name in ("lam", "mu", "l", "low", "high") if name in data]
    where, name = rng.choice(places)
    if where[name] is not None:
        where[name] = other_double(rng, where[name])


def laws_in(data):
    if "objects" in data:
        return [one["law"] for one in data["objects"] if "law" in one]
    return [wall["law"] for wall in data["walls"]] if "walls" in data else [data["law"]]


def wider(rng, data, _others):
    """A claim that says more than was proven, or is wider or elsewhere."""
    claims = data.get("claims")
    if claims is None:
        data["low"], data["high"] = (
            (float.fromhex(data[name]) * (1 + rng.uniform(-0.1, 0.1))).hex() for name in ("low", "high")
        )
        return
    path = rng.choice(list(leaves(claims)))
    text = at(claims, path)
    if isinstance(text, bool):
        put(claims, path, not text)
    elif text in ("stable", "unstable", "undecided"):
        put(claims, path, rng.choice(("stable", "unstable", "undecided")))
    elif is_decimal(text):
        put(claims, path, other_decimal(rng, text))


def true_of_it(_rng, data, _others):
    """The strongest claims there are."""
    claims = data.get("claims", {})
    for name, best in (("least_period", True), ("stable", True), ("stability", "stable"), ("symmetric", True)):
        if name in claims:
            claims[name] = best


# What he does to the gap map


def word(rng, data, _others):
    """Another word: turned, doubled, reversed, a letter changed."""
    w = data["word"]
    i = rng.randrange(len(w))
    turned = w[i:] + w[:i]
    swapped = w[:i] + ("L" if w[i] == "R" else "R") + w[i + 1 :]
    data["word"] = rng.choice(
        (turned, w * 2, w * 3, w[::-1], swapped, w + "L", w + "R", w[1:], "", "L" * len(w), w.lower())
    )


def edge(rng, data, _others):
    """Another edge, or another point of it."""
    data["edge"] = rng.choice(("gr", "bc", "pd", "lp", data["edge"], data["edge"]))
    data["at"] = rng.choice((0, 1, 2, 3, -1, 9, True, data["at"]))


def again(rng, data, _others):
    """The cycle gone round twice or three times, said to be one of that least period."""
    times = rng.choice((2, 2, 3))
    k = data["word"].count("R")
    data["word"] *= times
    data["centre"] = [*data["centre"][:k] * times, *data["centre"][k:]]
    data["claims"]["roots"] = data["claims"]["roots"] * times
    fitting_matrix(rng, data, _others)


def turns(rng, data, _others):
    """Blocks left out, added, or turned elsewhere."""
    found, low, high = data["turns"], float.fromhex(data["low"]), float.fromhex(data["high"])
    i = rng.randrange(len(found) + 1)
    how = rng.randrange(4)
    if how == 0:
        data["turns"] = found[:i]
    elif how == 1:
        found.insert(i, rng.choice((low, high, (low + high) / 2)).hex())
    elif found:
        found[i % len(found)] = rng.choice((low, high, rng.uniform(low, high), -high, 2 * high)).hex()


def interval(rng, data, _others):
    """Other ends of the interval of mu, swapped or moved over a window."""
    low, high = float.fromhex(data["low"]), float.fromhex(data["high"])
    low, high = rng.choice(
        (
            (high, low),
            (low, high * 1.3),
            (low * 0.7, high),
            (0.0, high),
            (-high, high),
            (low, low),
            (low + 0.01, high + 0.01),
        )
    )
    data["low"], data["high"] = low.hex(), high.hex()
    data["turns"] = [rng.choice((low, high)).hex() for _ in data["turns"]]
    if data["turns"]:
        data["turns"][0] = high.hex()


# What he does to the oscillator


def signature(rng, data, _others):
    """Another number of impacts or periods, or another precision."""
    if rng.random() < 0.3:
        data["precision"] = rng.choice((512, 1024, 53, 0, -256, True, 257))
        return
    name = rng.choice(("impacts", "periods"))
    if name == "impacts" and "walls" in data:
        other_hits(rng, data)
        return
    data[name] = rng.choice((data[name] + 1, data[name] * 2, data[name] - 1, 0, -1, 7, True))


def other_hits(rng, data):
    """Impacts at other walls, in another order, one more or less."""
    hits = data["impacts"]
    names = [*hits, *(wall["name"] for wall in data["walls"])]
    i = rng.randrange(len(hits) + 1)
    data["impacts"] = rng.choice(
        (
            [*hits[1:], *hits[:1]],
            [*hits[:i], rng.choice(names), *hits[i:]],
            [*hits[:i], *hits[i + 1 :]],
            [*hits[:i], rng.choice(names), *hits[i + 1 :]],
            [rng.choice(("Z", "a", "", 'A"; it is stable', 1, None, *names)) for _ in hits],
            len(hits),
        )
    )


def count_of(data):
    """The number of impacts."""
    return len(data["impacts"]) if "walls" in data else data["impacts"]


def twice(rng, data, others):
    """The orbit gone round twice, or begun at another impact, said to be of that least period."""
    n = count_of(data)
    if n == 0 or "unique" not in data:
        data["periods"] *= 2
        return
    with precision(256):
        turn = 2 * pi() * data["periods"] / double(float.fromhex(data["model"]["omega"]))
    for name in ("centre", "radius", "unique"):
        t, w = data[name][:n], data[name][n:]
        with precision(256):
            later = [x if name != "centre" else text_of(exact(x) + turn) for x in t]
        data[name] = [*t, *later, *w, *w]
    data["impacts"], data["periods"] = 2 * data["impacts"], 2 * data["periods"]
    data["cuts"] = [*data["cuts"], *data["cuts"]]
    size = 4 * n
    claims = data["claims"]
    claims["box"], claims["apart"] = [["0", "0"] for _ in range(size)], [claims["apart"][0]] * size
    claims["incoming"], claims["least_period"] = [["0", "0"] for _ in range(2 * n)], True
    fitting_matrix(rng, data, others)


def text_of(x):
    m, e = x.mid().man_exp()
    return f"{int(m):#x}p{int(e)}"


def law(rng, data, _others):
    """Another law: a node changed, or a parameter of another name."""
    one = rng.choice(laws_in(data))
    paths = list(leaves(one["after"]))
    how = rng.randrange(4)
    if how == 0 and paths[0]:
        new = ("v", "0x1.0p+0", "0x0.0p+0", "r", "V", "alpha", "+", "*", "-", ">=", "<")
        put(one["after"], rng.choice(paths), rng.choice(new))
    elif how == 1:
        tree = one["after"]
        one["after"] = rng.choice(
            (["-", tree], ["abs", tree], ["+", tree, (2.0**-60).hex()], ["*", (1.0).hex(), tree], ["/", tree, tree])
        )
    elif how == 2:
        names = ("alpha", "k", "cos1", "sigma", "offset", "e; so it is stable", "unused", "r")
        one["parameters"][rng.choice(names)] = (0.5).hex()
    elif "offset_name" in data.get("model", ()):
        data["model"]["offset_name"] = rng.choice(("offset", "d", "k", "the offset, which is stable", ""))


def kicked(rng, data, _others):
    """Slow impacts at a wall are thrown back, which the orbit's own are not."""
    one = rng.choice(laws_in(data))
    one["after"] = ["if", [">", "v", (-(2.0**-60)).hex()], (0.5).hex(), one["after"]]


def unknown(rng, data, _others):
    """Another parameter is said to be the unknown one."""
    old = data["parameter"]
    if "model" not in data or "walls" in data:
        unknown_of_another(rng, data, old)
        return
    places = {"offset": ("model", "offset"), "alpha": ("model", "alpha"), "r": ("law", "r"), "V": ("law", "V")}
    of, name = rng.choice(list(places.values()))
    where = data["model"] if of == "model" else data["law"]["parameters"]
    before = data["model"] if old["of"] == "model" else data["law"]["parameters"]
    if name in where and old["name"] in before:
        before[old["name"]] = where[name]
        where[name] = None
    data["parameter"] = {"of": of, "name": name}


def unknown_of_another(rng, data, old):
    """Another parameter of the model, of a wall or an object or its law has no value, or is said to have none."""
    if "objects" in data:
        parts = data["objects"]
        groups = {"the table": {name: data[name] for name in table.NUMBERS}}
    else:
        parts, groups = data["walls"], {"model": data["model"]}
    for one in parts:
        groups |= {one["name"]: one.get("shape", one)}
        groups |= {f"law of {one['name']}": one["law"]["parameters"]} if "law" in one else {}
    of = rng.choice(list(groups))
    name = rng.choice([key for key, text in groups[of].items() if text is None or is_double(text)])
    before = groups[old["of"]]
    if old["name"] in before and rng.random() < 0.7:
        before[old["name"]], groups[of][name] = groups[of][name], None
    data["parameter"] = {"of": rng.choice((of, of, of, f"law of {of}", "law", "B", "the table")), "name": name}


def event(rng, data, _others):
    """Another bifurcation, another coordinate along the curve, ends the wrong way round."""
    how = rng.randrange(4)
    if how == 0:
        data["type"] = rng.choice(("pd", "lp", "ns", "gr", "bc"))
        data["dip"] = data["dip"] if data["type"] == "gr" else {}
    elif how == 1:
        data["pinned"] = rng.choice((0, 1, 2, 3, -1, len(data["centre"]) - 1))
    elif how == 2:
        data["ends"].reverse()
    else:
        data["ends"][0] = deepcopy(data["ends"][1])


def cuts(rng, data, _others):
    """Cuts or the dip moved or swapped; impacts in another order of time."""
    if data.get("dip") and rng.random() < 0.5:
        dip = data["dip"]
        if "wall" in dip and rng.random() < 0.4:
            dip["wall"] = rng.choice([wall["name"] for wall in data["walls"]])
            return
        a, b = rng.sample(("from", "to", "time"), 2)
        dip[a], dip[b] = dip[b], dip[a]
        return
    if not data["cuts"]:
        return
    one = rng.choice(data["cuts"])
    how = rng.randrange(3)
    if how == 0:
        one.reverse()
    elif how == 1:
        one[rng.randrange(2)] = other_exact(rng, one[0])
    else:
        n = count_of(data)
        data["centre"][:n] = rng.sample(data["centre"][:n], n)


def later(rng, data, _others):
    """The orbit a period of the forcing later: true, or false by a bit."""
    n = count_of(data)
    turn = (
        2 * 3.141592653589793 * rng.choice((1, data["periods"], 0.5)) / float.fromhex(data["model"]["omega"] or "0x1p0")
    )
    for i in range(n):
        data["centre"][i] = text_of(exact(data["centre"][i]) + number(int(turn * 2**60), -60))


# What he does with the equations themselves


def system(data):
    """The equations at the centre, and their derivatives by all unknowns but the pinned one."""
    if "word" in data:
        letters = gap.Word(data["word"])
        k, edged = letters.k, "edge" in data
        lam, l = (double(float.fromhex(data[name])) for name in ("lam", "l"))
        z = [exact(text) for text in data["centre"]]
        powers = gap.Powers(letters, lam)
        F = gap.equations(letters, powers, z[:k], z[k] if edged else double(float.fromhex(data["mu"])), l)
        D = gap.slopes(letters, powers, z[:k])
        if edged:
            last, slope = gap.event(letters, powers, data["edge"], data["at"], z, z, l)
            F, D = [*F, last], [*D, slope]
        return F, [[row_.get(j, number(0)) for j in range(k + edged)] for row_ in D]
    if "objects" in data:
        x, pinned = [exact(text) for text in data["centre"]], data.get("pinned", len(data["centre"]))
        found = table_value.Problem(data) if "parameter" in data else table.Table(data)
        legs = (found.legs(x, sensitive=True),) if "parameter" in data else ()
        F = [one.x if isinstance(one, Gradient) else one for one in found.defect(x, *legs)]
        return F, [one[:pinned] + one[pinned + 1 :] for one in found.derivative(x, *legs)]
    unknown = (data["parameter"]["of"], data["parameter"]["name"]) if "parameter" in data else None
    problem = Problem(data, unknown)
    x = [exact(text) for text in data["centre"]]
    legs = problem.legs(x, sensitive=unknown is not None)
    pinned = data.get("pinned", len(x))
    return problem.defect(x, legs), [one[:pinned] + one[pinned + 1 :] for one in problem.derivative(x, legs)]


def floats(rows):
    return np.array([[float(x) for x in one] for one in rows])


def fitting_matrix(_rng, data, _others):
    """The preconditioner that the equations at the centre ask for."""
    with precision(256):
        inverse = np.linalg.inv(floats(system(data)[1]))
    data["preconditioner"] = [[x.hex() for x in one] for one in inverse.tolist()]


def solved_again(rng, data, others):
    """A parameter is changed a little, and the equations are solved again: all fits, and may even be true."""
    if "objects" in data:
        places = [(data, name) for name in ("rho", "tilt", "energy")]
        places += [(one["shape"], name) for one in data["objects"] for name in one["shape"]]
        places += [(law["parameters"], p) for law in laws_in(data) for p in law["parameters"]]
    elif "model" in data:
        places = [(data["model"], "alpha"), (data["model"], "offset")]
        places += [(law["parameters"], p) for law in laws_in(data) for p in law["parameters"] if p in "rV"]
        places += [(wall, "sigma") for wall in data.get("walls", ())]
    else:
        places = [(data, name) for name in ("lam", "mu", "l") if name in data]
    where, name = rng.choice(places)
    if where[name] is not None:
        where[name] = (float.fromhex(where[name]) * (1 + rng.choice((1e-3, 1e-2, 0.1, 0.5)) * rng.uniform(-1, 1))).hex()
    pinned = data.get("pinned", -1)
    with precision(256):
        newton(data, pinned)
    fitting_matrix(rng, data, others)


def newton(data, pinned=-1):
    """The centre is moved to a zero of the equations, if Newton's method finds one."""
    for _ in range(6):
        F, D = system(data)
        Y = np.linalg.inv(floats(D))
        step = Y @ np.array([float(x) for x in F])
        free = [i for i in range(len(data["centre"])) if i != pinned]
        for i, by in zip(free, step.tolist(), strict=True):
            data["centre"][i] = text_of(exact(data["centre"][i]) - double(by))


def elsewhere(rng, data, others):
    """A curve of orbits that is right, but beside the bifurcation or over it, along another coordinate, or wider."""
    how, pinned = rng.randrange(3), data["pinned"]
    with precision(256):
        if how == 0:
            by = exact(data["radius"][pinned]) * rng.choice((1, 2, -2, 5, -1000))
            data["centre"][pinned] = text_of(exact(data["centre"][pinned]) + by)
        elif how == 1:
            data["pinned"] = rng.randrange(len(data["centre"]))
        else:
            factor = number(1, rng.choice((-10, 10, 20, 30)))
            data["radius"] = [text_of(exact(x) * factor) for x in data["radius"]]
    fitting_matrix(rng, data, others)
    data["centre"] = closed(data, data["centre"])
    pinned = data["pinned"]
    for side, end in zip((-1, 1), data["ends"], strict=True):
        x = list(data["centre"])
        with precision(256):
            x[pinned] = text_of(exact(x[pinned]) + side * exact(data["radius"][pinned]))
        end["centre"] = closed(data, x)
        end["radius"] = ["0x1p-90" if one == "0x0p0" else one for one in end["radius"]]
        end["radius"][pinned] = "0x0p0"
    if data["dip"] and rng.random() < 0.5:
        looked_at_where_it_crosses(data)


def looked_at_where_it_crosses(data):
    """The dip, if it goes below the wall or into the part, is looked at where it does, and not where it is lowest.

    Its height there changes its sign along the curve, whatever that at its lowest does.
    """
    dip, size = data["dip"], len(data["centre"]) - 1
    with precision(256):
        x = [exact(text) for text in data["centre"]]
        if "objects" in data:
            at = table_value.Problem(data).legs(x)
            h = table_value._path(at, x[:size], table_value._dip(data, at))[1]
            height = partial(plane.value, h)
        else:
            problem = Problem(data, (data["parameter"]["of"], data["parameter"]["name"]))
            wall = [one.name for one in problem.walls].index(dip.get("wall", ""))
            height = problem.seen(x, problem.legs(x)[dip["flight"] - 1], wall).at
        above, below = exact(dip["from"]), exact(dip["time"])
        if not height(below) < 0:
            return
        for _ in range(200):
            middle = ((above + below) / 2).mid()
            above, below = (middle, below) if height(middle) > 0 else (above, middle)
        dip["time"] = text_of(above)


def closed(data, x, steps=3):
    """An orbit near x with its pinned coordinate, by the preconditioner."""
    C = [[double(float.fromhex(one)) for one in row_] for row_ in data["preconditioner"]]
    of, free = data["parameter"], list(range(len(x)))
    problem = table_value.Problem(data) if "objects" in data else Problem(data, (of["of"], of["name"]))
    del free[data["pinned"]]
    with precision(256):
        point = [exact(text) for text in x]
        for _ in range(steps):
            F = problem.defect(point, problem.legs(point))
            for i, line in zip(free, C, strict=True):
                point[i] = (point[i] - sum((c * f for c, f in zip(line, F, strict=True)), number(0))).mid()
        return [text_of(one) if i in free else x[i] for i, one in enumerate(point)]


def orthogonal(rng, data, _others):
    """A matrix of low rank whose rows are orthogonal to what the equations leave, and radii of the wrong sign.

    Then Y F = 0 wherever the centre lies, and |Y F| + |I - Y D| r < r says for r < 0 that |I - Y D| is large.
    """
    some = {"lam", "mu", "l"} & set(data)
    if some and rng.random() < 0.7:
        name = rng.choice(sorted(some))
        data[name] = (float.fromhex(data[name]) * rng.uniform(0.8, 1.2)).hex()
    i = rng.randrange(len(data["centre"]))
    far = rng.choice((2, 20, 200))
    data["centre"][i] = text_of(exact(data["centre"][i]) * number(1000 + rng.randint(-far, far)) / 1000)
    with precision(256):
        F = np.array([float(x) for x in system(data)[0]])
    if len(F) == 1 or not F.any():
        raise ValueError("nothing is orthogonal to it")
    line = np.array([rng.uniform(-1, 1) for _ in F])
    line = (line - line @ F / (F @ F) * F) * rng.choice((5.0, 40.0, 1000.0))
    data["preconditioner"] = [[x.hex() for x in line.tolist()] for _ in F]
    e = rng.choice((20, 36, 44))
    for name, text in (
        ("radius", f"-0x1p-{e}"),
        ("unique", f"{rng.choice(('', '-', '-'))}0x1p-{e + rng.choice((-10, 10))}"),
    ):
        if name in data:
            data[name] = [text] * len(data[name]) if isinstance(data[name], list) else text


def anywhere(rng, data, others):
    """Other parameters and another word, and a zero of its equations from anywhere: an orbit of the map, or none."""
    letters = ["R", *rng.choices("LLR", k=rng.randrange(8))]
    rng.shuffle(letters)
    data["word"] = "".join(letters)
    for name in {"lam", "mu", "l"} & set(data):
        data[name] = rng.uniform(-1.0, 1.0).hex()
    if "edge" in data:
        data["edge"] = rng.choice(("gr", "bc", "pd", "lp"))
        wanted = {"gr": "R", "bc": "L"}.get(data["edge"])
        data["at"] = rng.choice([j for j, letter in enumerate(letters, start=1) if letter == wanted] or [0])
    k = letters.count("R")
    data["centre"] = [text_of(double(rng.uniform(0.01, 1.0))) for _ in range(k + ("edge" in data))]
    data["claims"]["roots"] = [["0", "0"] for _ in range(k)]
    data["radius"], data["unique"] = "0x1p-90", f"0x1p-{rng.choice((4, 10, 30))}"
    with precision(256):
        for _ in range(4):
            newton(data)
    fitting_matrix(rng, data, others)


# What he does to walls


def wall_renamed(rng, data, _others):
    """Other names: exchanged, of both the same, no names at all; the impacts follow, or not."""
    walls = data["walls"]
    old = [wall["name"] for wall in walls]
    new = rng.choice(
        (
            old[::-1],
            [rng.choice("ABLRZ") for _ in old],
            [old[0]] * len(old),
            [rng.choice(("C", "S", "a", "AB", "", "A'", 'A" is stable; "', "A\n", "\u0391", 1)) for _ in old],
        )
    )
    for wall, name in zip(walls, new, strict=True):
        wall["name"] = name
    if rng.random() < 0.7:
        data["impacts"] = [new[old.index(name)] for name in data["impacts"]]


def walls_exchanged(rng, data, _others):
    """Walls, or what two of them have, in each other's place: motions, positions, laws, sides."""
    one, two = data["walls"]
    names = rng.choice((("cos", "sin"), ("sigma",), ("law",), ("side",), ("sigma", "cos", "sin"), ("sin",), ()))
    for name in names:
        one[name], two[name] = two[name], one[name]
    if not names:
        data["walls"].reverse()


def wall_dropped(rng, data, _others):
    """A wall is left out, or there is one more; its impacts go with it, or not."""
    walls = data["walls"]
    i = rng.randrange(len(walls))
    if rng.random() < 0.2:
        more = {**deepcopy(walls[i]), "name": rng.choice("DE"), "side": rng.choice(("above", "below"))}
        if rng.random() < 0.7:
            more["sigma"] = rng.choice((50.0, -50.0, 0.0, 2.0)).hex()
        walls.insert(rng.choice((0, len(walls))), more)
        return
    gone = walls.pop(i)["name"]
    how = rng.randrange(3)
    if how == 0:
        data["impacts"] = [name for name in data["impacts"] if name != gone]
    elif how == 1 and walls:
        data["impacts"] = [walls[0]["name"] for _ in data["impacts"]]


def side_flipped(rng, data, _others):
    """A wall is on the other side of the ball, and the whole may be seen upside down."""
    if rng.random() < 0.5:
        wall = rng.choice(data["walls"])
        wall["side"] = {"below": "above", "above": "below"}[wall["side"]]
        return

    def turned(text):
        return (-float.fromhex(text)).hex()

    for part in (data["model"], *data["walls"]):
        for name in ("cos", "sin"):
            part[name] = [turned(x) for x in part[name]]
    data["model"]["offset"] = turned(data["model"]["offset"])
    for wall in data["walls"]:
        wall["sigma"] = turned(wall["sigma"])
        if rng.random() < 0.8:
            wall["side"] = {"below": "above", "above": "below"}[wall["side"]]
    if rng.random() < 0.8:
        data["walls"].reverse()


def wall_moved(rng, data, others):
    """A wall stands a little elsewhere, or moves a little otherwise: less than the clearance, or more."""
    wall = rng.choice(data["walls"])
    by = rng.choice((1e-12, 1e-6, 1e-3, 0.05, 1.0)) * rng.uniform(-1, 1)
    if rng.random() < 0.6:
        wall["sigma"] = (float.fromhex(wall["sigma"]) + by).hex()
    else:
        wall["cos"], wall["sin"] = [*wall["cos"], by.hex()], [*wall["sin"], (0.0).hex()]
    if rng.random() < 0.5:
        with precision(256):
            newton(data)
        fitting_matrix(rng, data, others)


def image(rng, data, others):
    """The mirror image of the orbit, half a period later, said to be one of the same model."""
    names = [wall["name"] for wall in data["walls"]]
    data["impacts"] = [names[1 - names.index(name)] for name in data["impacts"]]
    n = len(data["impacts"])
    with precision(256):
        half = pi() * data["periods"] / double(float.fromhex(data["model"]["omega"]))
        data["centre"][:n] = [text_of(exact(x) + half * rng.choice((1, 1, -1))) for x in data["centre"][:n]]
    if rng.random() < 0.5:
        fitting_matrix(rng, data, others)
    data["claims"]["symmetric"] = True


# What he does to tables


def other_word(rng, data, _others):
    """Impacts at other objects or parts, begun later, one more or less, the other way round."""
    hits = data["impacts"]
    i = rng.randrange(len(hits))
    names = [one["name"] for one in data["objects"]]
    parts = ("disc", "left", "right", "start", "stop", "outer", "inner", "drain", "", 1)
    new = [rng.choice(names), rng.choice(parts)]
    data["impacts"] = rng.choice(
        (
            [*hits[1:], *hits[:1]],
            hits[::-1],
            [*hits[:i], [hits[i][0], rng.choice(parts)], *hits[i + 1 :]],
            [*hits[:i], new, *hits[i + 1 :]],
            [*hits[:i], new, *hits[i:]],
            [*hits[:i], *hits[i + 1 :]],
            [[rng.choice((*names, "Z", "", None)), part] for _name, part in hits],
            len(hits),
        )
    )


def begun_later(rng, data, others):
    """The orbit begun at another impact, with all that belongs to it: true."""
    n = len(data["impacts"])
    k = rng.randrange(1, n)
    data["impacts"] = data["impacts"][k:] + data["impacts"][:k]
    for where, names in ((data, ("centre", "radius", "unique")), (data["claims"], ("box", "apart"))):
        for name in names:
            u, t = where[name][:n], where[name][n:]
            where[name] = u[k:] + u[:k] + t[k:] + t[:k]
    data["claims"]["incoming"] = data["claims"]["incoming"][k:] + data["claims"]["incoming"][:k]
    fitting_matrix(rng, data, others)


def round_twice(rng, data, others):
    """The orbit gone round twice, said to be one of that least period."""
    n = len(data["impacts"])
    data["impacts"] = 2 * data["impacts"]
    for where, names in ((data, ("centre", "radius", "unique")), (data["claims"], ("box", "apart"))):
        for name in names:
            where[name] = 2 * where[name][:n] + 2 * where[name][n:]
    data["claims"]["incoming"], data["claims"]["least_period"] = 2 * data["claims"]["incoming"], True
    if data["energy"] is None:
        data["claims"]["sums"] = data["claims"]["sums"][:3]
    fitting_matrix(rng, data, others)


def in_the_way(rng, data, _others):
    """One more object: on the way, beside it, or far off."""
    x, y = (rng.uniform(-1, 7) for _ in range(2))
    size = rng.choice((1e-9, 0.01, 0.3, 1.0))
    law = deepcopy(laws_in(data)[0])
    shapes = {
        "disc": {"x": x, "y": y, "radius": size},
        "segment": {"x1": x, "y1": y, "x2": x + size, "y2": y + rng.uniform(-1, 1)},
        "drain": {"x1": x, "y1": y, "x2": x + size, "y2": y + rng.uniform(-1, 1)},
        "arc": {"x": x, "y": y, "radius": size, "start": rng.uniform(0, 6), "stop": rng.uniform(6, 12)},
    }
    kind = rng.choice(sorted(shapes))
    new = {"name": rng.choice(("new", "A", "x_1")), "kind": kind}
    new["shape"] = {name: float(value).hex() for name, value in shapes[kind].items()}
    data["objects"].insert(rng.randrange(2) * len(data["objects"]), new | ({"law": law} if kind != "drain" else {}))


def object_changed(rng, data, others):
    """An object moved, turned into another kind, renamed, or left out; solved again, or not."""
    i = rng.randrange(len(data["objects"]))
    one, how = data["objects"][i], rng.randrange(5)
    if how == 0:
        name = rng.choice(sorted(one["shape"]))
        by = rng.choice((1e-12, 1e-6, 1e-3, 0.05, 1.0)) * rng.uniform(-1, 1)
        one["shape"][name] = (float.fromhex(one["shape"][name]) + by).hex()
        if rng.random() < 0.6:
            with precision(256):
                newton(data)
            fitting_matrix(rng, data, others)
    elif how == 1:
        one["kind"] = rng.choice(("disc", "segment", "arc", "drain", "flipper"))
    elif how == 2:
        old, one["name"] = one["name"], rng.choice(("A", "new", "", "a b", 'A"; it is stable', "\u0391", 1))
        if rng.random() < 0.5:
            data["impacts"] = [[one["name"] if name == old else name, part] for name, part in data["impacts"]]
    elif how == 3:
        del data["objects"][i]
    else:
        data["objects"].append(deepcopy(one))


def other_energy(rng, data, others):
    """Another energy, or one where none is conserved, or none where it is."""
    old = data["energy"]
    data["energy"] = rng.choice((None, (0.5).hex(), (3.0).hex(), (-1.0).hex(), (1e300).hex(), old))
    if old is not None and data["energy"] is not None and rng.random() < 0.6:
        with precision(256):
            newton(data)
        fitting_matrix(rng, data, others)


def dip_elsewhere(rng, data, _others):
    """The dip of a flight moved, turned round, of another part, object or flight, or there where none is."""
    dip = data["dip"]
    names = [one["name"] for one in data["objects"]]
    if not dip:
        dip |= {
            "flight": 1,
            "object": rng.choice(names),
            "part": "disc",
            "from": "0x1p-3",
            "to": "0x1p-1",
            "time": "0x1p-2",
        }
        data["type"] = rng.choice(("gr", data["type"]))
        return
    how = rng.randrange(5)
    if how == 0:
        a, b = rng.sample(("from", "to", "time"), 2)
        dip[a], dip[b] = dip[b], dip[a]
    elif how == 1:
        dip["flight"] = rng.choice((dip["flight"] + 1, dip["flight"] - 1, 0, True, 99))
    elif how == 2:
        dip["object"] = rng.choice((*names, "Z", "", None))
    elif how == 3:
        dip["part"] = rng.choice(("disc", "left", "right", "start", "stop", "outer", "inner", "drain", 1))
    else:
        name = rng.choice(("from", "to", "time"))
        dip[name] = other_exact(rng, dip[name])


COMMON = (one_number, one_number, roles, dropped, of_a_neighbour, neighbours_proof, parameter, wider, true_of_it)
SOLVED = (*COMMON, radii, matrix, fitting_matrix, solved_again, orthogonal)
OSCILLATOR = (*SOLVED, signature, law, kicked, cuts, later)
WALLS = (wall_renamed, walls_exchanged, wall_dropped, side_flipped, wall_moved, image)
TABLES = (other_word, begun_later, round_twice, in_the_way, object_changed, other_energy)
WAYS = {
    "periodic orbit": (*OSCILLATOR, twice),
    "periodic orbit with walls": (*OSCILLATOR, twice, *WALLS, *WALLS),
    "periodic orbit on a table": (*SOLVED, law, kicked, *TABLES, *TABLES),
    "bifurcation value": (*OSCILLATOR, unknown, event),
    "bifurcation value with walls": (*OSCILLATOR, unknown, event, *WALLS),
    "bifurcation value on a table": (
        *SOLVED,
        law,
        kicked,
        other_word,
        in_the_way,
        object_changed,
        other_energy,
        unknown,
        event,
        dip_elsewhere,
        dip_elsewhere,
    ),
    "gap map orbit": (*SOLVED, word, again, anywhere),
    "gap map edge": (*SOLVED, word, edge, again, anywhere),
    "gap map without attracting orbits": (*COMMON, turns, turns, interval),
}


def forgeries(kind, documents, count, seed, only=()):
    """Yield so many forged certificates of a kind, each with the names of what was done to it."""
    rng = random.Random(f"{seed} {kind}")
    true = [one for one in documents if one["kind"] == kind]
    made = 0
    while made < count:
        base = rng.choice(true)
        data, others = deepcopy(base["data"]), [one["data"] for one in true]
        ways = only or rng.sample(WAYS[kind], rng.choice((1, 1, 1, 2, 2, 3)))
        try:
            with np.errstate(all="ignore"):
                for way in ways:
                    way(rng, data, others)
        except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError):
            continue  # an earlier change has left nothing of what this one would change
        if data == base["data"]:
            continue
        honest = rng.random() < 0.8
        if honest:
            fit(data)
        document = sealed(kind, data, base["inequalities"], honest)
        if document["data"] != base["data"]:
            made += 1
            yield " and ".join(way.__name__ for way in ways), document


def fit(data):
    """Make the distances claimed fit the boxes, as far as there are any."""
    try:
        r, u, claims = data["radius"], data["unique"], data["claims"]
        if isinstance(r, list):
            claims["apart"] = [below(exact(b) - exact(a), 3) for a, b in zip(r, u, strict=True)]
        else:
            claims["apart"] = below(exact(u) - exact(r), 3)
    except Exception:
        pass
