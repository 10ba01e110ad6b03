"""Configurations at random: their grammar with wrong, missing and extreme parts, and files that are broken."""

from __future__ import annotations

import datetime

from grazing.catalogue import studies
from grazing.config import toml_of
from grazing.config.parameters import parameter_names
from grazing.config.schema import MAPS
from grazing.config.settings import SETTINGS, settings_of

TEXTS = [
    "",
    " ",
    "0:1:3",
    "0:1",
    "1:0:3",
    "0:1:-1",
    "0:1:0",
    "0:1:1e9",
    "0:1:999999999999",
    "a:b:c",
    "0:1:3:log",
    "1:2:3:log",
    "-1:1:3:log",
    ":",
    "::",
    ":::",
    "nan:1:3",
    "0:inf:3",
    "-1e308:1e308:3",
    "1e400:1:2",
    "0.1,0.2",
    ",",
    "0.1,,0.2",
    "0.1,a",
    "default",
    "=",
    "a=b",
    "V=0.1:0.6",
    "V=0.6:0.1",
    "v=0",
    "v=0,w=1",
    "q=1",
    "001",
    "LLR",
    "0C",
    "0(",
    "01" * 300,
    "x" * 3000,
    "\0",
    "\x1b[31m",
    "é",
    "\ud7ff",
    "📈",
    "../../etc/passwd",
    "file.py:name",
    "nothing.py:P",
    ".py:",
    "a.py:b.py:c",
    "fast",
    "strict",
    "up",
    "down",
    "true",
    "false",
    "none",
    "lowest",
    "full",
    "gap",
    "impact",
    "active",
    "newton",
    "u",
    "v",
    "x",
    "tau",
    "d",
    "1",
    "-1",
    "1.5",
    "1e999",
    "0x10",
    "1_0",
    "٣",
    "1;2",
    "0.1,0;0.2,0",
    ";",
    "0:1,0:1",
    "0:1,-2:2",
    "2:7",
    "7:2",
    "1:99999",
]
NUMBERS = [
    0,
    1,
    2,
    3,
    -1,
    7,
    10**6,
    10**18,
    2**63,
    2**64,
    10**30,
    10**400,
    0.0,
    -0.0,
    0.1,
    0.5,
    1.0,
    -0.5,
    1e-300,
    5e-324,
    1e300,
    1e308,
    -1e308,
    float("nan"),
    float("inf"),
    -float("inf"),
    True,
    False,
]


def value(random, depth=0):
    """Return any value that TOML can write."""
    kind = random.random()
    if kind < 0.4:
        return random.choice(NUMBERS)
    if kind < 0.8 or depth > 2:
        return random.choice(TEXTS)
    if kind < 0.83:
        return random.choice([datetime.date(2000, 1, 1), datetime.time(1, 2), datetime.datetime(2000, 1, 1, 1)])
    if kind < 0.93:
        return [value(random, depth + 1) for _ in range(random.randrange(4))]
    return {
        random.choice([*parameter_names(), "q", "", "a b"]): value(random, depth + 1)
        for _ in range(random.randrange(3))
    }


def sound(random, study):
    """Return a configuration of a study that is near to one that works, and small."""
    known = studies()[study]
    kind = random.choice([*MAPS, "stroboscopic", "gap"]) if known.of == "map" else "stroboscopic"
    coordinates = {"gap": ["x"], "normal-form": ["x"], "impact": ["tau", "v_plus"]}.get(kind, ["u", "v"])
    names = (
        coordinates if known.varies == "coordinate" else ["mu", "l"] if kind in ("gap", "normal-form") else ["d", "V"]
    )
    found = {"study": study, "map": kind}
    if kind == "gap":
        found["parameters"] = {"lam": 0.5, "l": 0.1, "mu": 0.05}
    many = random.randint(known.least, max(known.most, known.least))
    written = "0.1:0.2" if known.form == "bounds" else "0.1:0.2:3"
    found["vary"] = {name: written for name in names[:many]}
    for name in found["vary"]:
        found.get("parameters", {}).pop(name, None)
    usual = {
        "state": [0.1] * len(coordinates),
        "starts": 2,
        "transient": 3,
        "keep": 4,
        "steps": 3,
        "period": [2],
        "until": 3.0,
        "samples": 5,
        "bins": 5,
        "exponent_steps": 3,
        "preimages": 0,
        "N": [3],
    }
    found["settings"] = {key: usual[key] for key in settings_of(study).model_fields if key in usual}
    return found


def configuration(random):
    """Return a configuration with up to three things in it changed."""
    found = sound(random, random.choice(list(studies())))
    for _ in range(random.randrange(4)):
        what = random.random()
        tables = [name for name in ("parameters", "vary", "settings") if isinstance(found.get(name), dict)]
        table = found[random.choice(tables)] if tables else found
        if what < 0.15:
            found[random.choice([*found, "law", "order", "unfold", "model", "curves", "coordinate", "q"])] = value(
                random
            )
        elif what < 0.25 and found:
            found.pop(random.choice(list(found)))
        elif what < 0.35 and table:
            table.pop(random.choice(list(table)))
        elif what < 0.65 and table:
            table[random.choice(list(table))] = value(random)
        elif what < 0.95:
            key = random.choice(
                [*SETTINGS, *parameter_names(), "phase", "cos1", "cos3", "sin1", "cos0", "u", "v", "x", "q", ""]
            )
            table[key] = value(random)
        else:
            found[random.choice(["a", "study", "settings", "vary"])] = value(random)
    return found


def text_of(random, config):
    """Return a configuration as bytes of a file, now and then broken."""
    try:
        text = toml_of(config)
    except Exception:  # dates and tables in tables are written by no configuration of ours
        text = "\n".join(f"{key} = {config[key]!r}" for key in config)
    data = text.encode("utf-8", "surrogatepass")
    if random.random() < 0.25:
        for _ in range(random.randint(1, 4)):
            i = random.randrange(len(data) + 1)
            cut = random.randrange(3)
            piece = random.choice(
                [
                    b"",
                    b"[",
                    b"]",
                    b'"',
                    b"=",
                    b"\n",
                    b"\x00",
                    b"\xff",
                    b"\xef\xbb\xbf",
                    b"#",
                    b"'''",
                    b"[[a]]\n",
                    b"[settings]\n",
                    b"a.b.c = 1\n",
                    b"\r",
                    b"{",
                    b"}",
                    b"1e5",
                    b"inf",
                    b"-",
                    b"\\u0000",
                ]
            )
            data = data[:i] + piece + data[i + cut :]
    return data
