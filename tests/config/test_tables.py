"""Pinball tables in files: those that ship, what is read, what is refused."""

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.objects import DISC, FLIPPER
from grazing.config import checked
from grazing.config.tables import shipped

GOOD = """
rho = 0.1
tilt = 0.3
[objects]
L = { kind = "flipper", x = 0, y = 0.0, length = 1.0, hub = 0.2, tip = 0.1, rest = -0.5, raised = 0.5, up = 9, down = 5,
      law = "newton", r = 0.8 }
A = { kind = "disc", x = 2.0, y = 6.0, radius = 0.5, law = "active", r = 0.9, V = 0.4 }
S = { kind = "segment", x1 = 3.0, y1 = 1.0, x2 = 3.0, y2 = 6.0, law = "triggered", r = 0.9, V = 0.4, trigger = 0.1 }
dome = { kind = "arc", x = 0.0, y = 8.0, radius = 3.0, start = 0.0, stop = 3.0, law = "newton", r = 1.0 }
out = { kind = "drain", x1 = -3.0, y1 = -1.0, x2 = 3.0, y2 = -1.0 }
""".replace(",\n     ", ",")


def read(tmp_path, text):
    file = tmp_path / "table.toml"
    file.write_text(text)
    return gz.read_table(file)


def test_a_file_says_all_that_calls_say(tmp_path):
    law = gz.newton(0.8)
    objects = [
        gz.flipper("L", (0, 0), 1.0, (0.2, 0.1), -0.5, 0.5, law, up=9, down=5),
        gz.disc("A", (2, 6), 0.5, gz.active(0.9, 0.4)),
        gz.segment("S", (3, 1), (3, 6), gz.triggered(0.9, 0.4, 0.1)),
        gz.arc("dome", (0, 8), 3.0, 0.0, 3.0, gz.newton(1.0)), gz.drain("out", (-3, -1), (3, -1)),
    ]  # fmt: skip
    assert read(tmp_path, GOOD) == gz.table(objects, 0.1, tilt=0.3)
    flips = "[flips]\nperiod = 2.0\nhold = 0.3\nphase = { L = 0.4 }\n"
    assert read(tmp_path, GOOD + flips) == gz.table(objects, 0.1, tilt=0.3, player=gz.flips(2.0, 0.3, 0.4))
    shot = "[plunger]\nx = 0\ny = 3.0\nangle = 1.5\nslow = 0\nfast = 2.0\n"
    assert read(tmp_path, GOOD + shot) == gz.table(objects, 0.1, tilt=0.3, plunger=gz.plunger((0, 3), 1.5, 0.0, 2.0))
    presses = "[presses]\nL = [0.5, 0.75, 2]\n"
    assert read(tmp_path, GOOD + presses) == gz.table(objects, 0.1, tilt=0.3, player=gz.presses(L=[0.5, 0.75, 2.0]))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rho = 0.1", "size = 0.1", "has 'size'; allowed are objects, rho, g, tilt, flips, presses, plunger"),
        ("rho = 0.1", "rho = -0.1", r"rho = -0\.1; allowed is rho >= 0"),
        ("[objects]", "[things]", "has 'things'; allowed are objects"),
        ('kind = "disc"', 'kind = "post"', r"objects\.A\.kind = 'post'; allowed are disc, segment"),
        ('kind = "disc"', "kind = []", r"objects\.A\.kind = \[\]; allowed are disc, segment"),
        ("radius = 0.5", "size = 0.5", r"objects\.A has 'size'; allowed are kind, x, y, radius, law, r, V"),
        ("radius = 0.5, ", "", r"objects\.A has no radius; it needs kind, x, y, radius"),
        ('law = "active"', 'law = "mine.py:law"', r"objects\.A\.law = 'mine\.py:law'; allowed are newton, active"),
        ("V = 0.4 }", 'V = "much" }', "V = 'much' is not a real number"),
        ("radius = 0.5", "radius = inf", r"objects\.A: radius = inf is not finite"),
        ("r = 0.9", "r = 2.0", r"objects\.A: r = 2; allowed is 0 <= r <= 1"),
        ("A = {", '"A.x" = {', r"objects\.A\.x: name of a disc is 'A\.x'"),
        ('"drain", ', '"drain", r = 1.0, ', r"objects\.out has 'r'; allowed are kind, x1"),
        ("y1 = -1.0", "y1 = nan", "nan is not finite"),
    ],
)
def test_wrong_files_are_refused_with_the_place(tmp_path, old, new, said):
    with pytest.raises(gz.InputError, match=said):
        read(tmp_path, GOOD.replace(old, new))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("objects = 3", "objects is 3; give a table of objects"),
        ("[objects]\nA = 3", r"objects\.A is 3; give its kind"),
        ("[objects]", "objects are"),
        ("x = ", "is not TOML"),
        (GOOD + "[flips]\nperiod = 2.0\n", "flips has no hold; it needs period, hold"),
        (GOOD + "[flips]\nperiod = 2.0\nhold = 0.1\n[presses]\nL = [1.0]\n", "has flips, presses; give one"),
        ("plunger = 3" + GOOD, "plunger is 3; give a table of keys and values"),
        ("plunger = { x = 0, y = 3 }" + GOOD, "plunger has no angle; it needs x, y, angle, slow, fast"),
        ("flips = 3" + GOOD, "flips is 3; give a table of keys and values"),
        ("presses = 3" + GOOD, "presses is 3; give the times of each flipper"),
        (GOOD + "[presses]\nM = [1.0]\n", "presses names 'M', which is no flipper"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, text, said):
    with pytest.raises(gz.InputError, match=said):
        read(tmp_path, text)


def test_all_that_is_wrong_with_a_table_is_said_at_once(tmp_path):
    wrong = (("rho = 0.1", "rho = -0.1\nsize = 3"), ("radius = 0.5", "radius = -1"), ("r = 1.0", "r = 2.0"))
    text = GOOD + "[flips]\nperiod = 2.0\n"
    for old, new in wrong:
        text = text.replace(old, new)
    said = ["table.toml has 'size'", "rho = -0.1", "flips has no hold", "objects.A: radius", "objects.dome: r = 2"]
    with pytest.raises(gz.InputError) as refused:
        read(tmp_path, text)
    first, *lines = str(refused.value).splitlines()
    assert first == "there are 5 errors:"
    assert [part for part, line in zip(said, lines, strict=True) if part in line] == said
    with pytest.raises(gz.InputError) as refused:
        checked({"study": "escape", "table": str(tmp_path / "table.toml"), "settings": {"starts": 0}})
    message = str(refused.value)
    assert all(f"table: {part}" in message for part in said[1:]) and "starts" in message


def test_all_that_is_wrong_with_one_object_is_said_at_once(tmp_path):
    wrong = 'kind = "disc", x = inf, size = 1, law = "newton", r = 2.0 }'
    with pytest.raises(gz.InputError) as refused:
        read(
            tmp_path, f'[objects]\n"A.x" = {{ {wrong}\nB = {{ law = 3, r = 1.0 }}\nC = {{ {wrong.replace("size", "y")}'
        )
    said = [
        "objects.A.x has 'size'", "objects.A.x has no y", "objects.A.x has no radius", "objects.A.x: name of a disc is",
        "objects.A.x: x = inf", "objects.A.x: r = 2", "objects.B.kind = None", "objects.B.law = 3",
        "objects.C has no radius", "objects.C: x = inf", "objects.C: r = 2",
    ]  # fmt: skip
    first, *lines = str(refused.value).splitlines()
    assert first == "there are 11 errors:"
    assert [part for part, line in zip(said, lines, strict=True) if part in line] == said


def test_a_name_of_no_table_is_told_from_a_file():
    with pytest.raises(gz.InputError, match=r"there is no file 'clasic'; tables that ship are classic, galton"):
        gz.read_table("clasic")
    with pytest.raises(gz.InputError, match=r"nothing\.toml"):
        gz.read_table("nothing.toml")
    with pytest.raises(gz.InputError, match="there is no file '9999"):
        gz.read_table("9" * 10_000)  # no file system has such a name


def test_a_file_of_very_many_objects_is_refused_at_once(tmp_path):
    """Each is held against every other, and 20,000 discs took minutes; of each that is wrong something is said."""
    disc = 'N{} = {{ kind = "disc", x = {}.0, y = 0.0, radius = 1.0, law = "newton", r = 0.9 }}\n'
    many = "".join(disc.format(i, 3 * i) for i in range(9_000))
    with pytest.raises(gz.InputError, match="has 9000 objects, 0 of them flippers; allowed are 2000"):
        read(tmp_path, "[objects]\n" + many)
    with pytest.raises(gz.InputError, match=r"^the table has 9000 objects, 0 of them flippers"):
        read(tmp_path, "[objects]\n" + many.replace("disc", "post"))
    [flipper] = [line for line in GOOD.splitlines() if line.startswith("L")]
    flippers = "".join(flipper.replace("L", f"L{i}", 1) + "\n" for i in range(21))
    with pytest.raises(gz.InputError, match="has 21 objects, 21 of them flippers; allowed are"):
        read(tmp_path, "[objects]\n" + flippers)
    long = read(tmp_path, "[objects]\n" + disc.format("N" * 100_000, 0))
    assert len(repr(long)) < 200


def test_four_tables_ship():
    assert shipped() == ["classic", "galton", "one_bumper", "three_discs"]
    assert gz.read_table("three_discs").params["C.y"] == 0.5 * 6.0 * np.sqrt(3.0)
    for name in shipped():
        gz.testing.check_table(gz.read_table(name), states=2)


def test_classic_is_a_pinball_machine():
    """Launches reach the bumpers and the slingshots; flippers keep balls in play; few end in a slide."""
    table = gz.read_table("classic")
    kinds = [one.kind for one in table.objects]
    assert kinds.count(DISC) == 5 and kinds.count(FLIPPER) == 2
    speeds, point = np.linspace(13.0, 24.0, 400), (table.plunger.x, table.plunger.y)
    found = gz.launches(table, speed=speeds)
    assert (found.exit.values == "").mean() < 0.02
    assert {"left_out", "out", "right_out"} <= set(found.exit.values.ravel())
    hit = [set(gz.trajectory(table, (*point, 0.0, speed), until=60.0).impact_wall.values) for speed in speeds[::10]]
    assert sum(bool(one & {"bumper1", "bumper2", "bumper3"}) for one in hit) > 20  # most of 40
    assert sum(bool(one & {"left_flipper", "right_flipper"}) for one in hit) > 20
    assert {one.name for one in table.objects if one.law is not None} == set.union(*hit)


def test_a_galton_board_spreads_balls_about_its_middle():
    table = gz.read_table("galton")
    found = gz.launches(table, (0.0, 9.0), np.linspace(0.1, 3.0, 200), np.linspace(0.01, 0.3, 5))
    places = np.array([int(name[3:]) - 8.5 for name in found.exit.values.ravel() if name.startswith("out")])
    inner, outer = np.abs(places) < 3.0, np.abs(places) > 6.0
    assert len(places) > 950 and abs(places.mean()) < 0.5 and inner.sum() > 5 * outer.sum()
