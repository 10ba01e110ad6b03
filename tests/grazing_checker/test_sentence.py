"""A sentence is about the model of its data: every number of that is read again from the words, and nothing else."""

import re

import pytest

from grazing_checker import check
from tests.grazing_checker.bases import GAP_NAMES, TABLE_NAMES, TABLE_VALUE_NAMES, bases
from tests.grazing_checker.documents import NAMES

VALUE = re.compile(r"\b([A-Za-z][\w.]*) = (-?[0-9][0-9.]*(?:e[+-]?[0-9]+)?)(?=[,;)]| and |$)")
#: What begins a wall or an object, with its name.
PART = re.compile(r'(?:u [<>] z_\w at the wall|the (?:disc|segment|arc|drain)) "(\w+)"')


def numbers_in(statement):
    """The numbers of the model in a sentence: of what is around walls and objects, and of each of these, by name."""
    model = statement.partition(" there is ")[0].partition(" has a")[0]
    first, *parts = PART.split(model)
    found = {"": values(first)}
    for name, text in zip(parts[::2], parts[1::2], strict=True):
        assert name not in found
        found[name] = values(text)
    return found


def values(text):
    pairs = VALUE.findall(text)
    assert len(dict(pairs)) == len(pairs)
    return {name: float(x) for name, x in pairs}


def amplitudes(part, front=""):
    return {f"{front}{kind}_{j}": x for kind in ("cos", "sin") for j, x in enumerate(part[kind], start=1)}


def law(part):
    return {f"p.{name}": x for name, x in part.get("law", {}).get("parameters", {}).items()}


def numbers_of(data):
    """The same of the data of a certificate."""
    if "objects" in data:
        found = {one["name"]: {**one["shape"], **law(one)} for one in data["objects"]}
        found[""] = {name: data[name] for name in ("g", "tilt")}
    elif "model" in data:
        model, walls = data["model"], data.get("walls", ())
        named = {name: x for name, x in model.items() if name not in ("cos", "sin", "offset_name")}
        named[model.get("offset_name", "offset")] = named.pop("offset")
        found = {"": named | amplitudes(model) | law(data)}
        for wall in walls:
            front = f"{wall['name']}."
            found[wall["name"]] = {f"{front}sigma": wall["sigma"]} | amplitudes(wall, front) | law(wall)
    else:
        found = {"": {name: data[name] for name in ("lam", "mu", "l") if name in data}}
    return {
        where: {name: float.fromhex(x) for name, x in some.items() if x is not None} for where, some in found.items()
    }


@pytest.mark.parametrize("name", [*NAMES, *GAP_NAMES, *TABLE_NAMES, *TABLE_VALUE_NAMES])
def test_a_sentence_says_each_number_of_the_model_by_its_name(name):
    document = bases()[name]
    assert numbers_in(document["statement"]) == numbers_of(document["data"])


def other_way_round(value):
    """The same JSON with the keys of every mapping in another order, as other programs write it."""
    if isinstance(value, dict):
        return {key: other_way_round(value[key]) for key in reversed(value)}
    return [*map(other_way_round, value)] if isinstance(value, list) else value


@pytest.mark.parametrize("name", ["stable", "own", "law pd", "pair", "R", "kicked", "in the bowl", "bowl pd"])
def test_the_sentence_does_not_depend_on_the_order_of_keys(name):
    """A proof that a program wrote with sorted keys, as it is hashed, was said not to follow from its data."""
    document = bases()[name]
    assert check(other_way_round(document)) == document["statement"]
