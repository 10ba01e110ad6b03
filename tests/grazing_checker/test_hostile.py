"""Documents made to break the checker, to keep it busy, or to make it say more than it proved."""

import json
import subprocess
import sys
from time import process_time

import pytest
from flint import arb

import grazing as gz
from grazing.proof.certify import certify
from grazing_checker import Rejected, check
from grazing_checker.__main__ import main
from grazing_checker.balls import number, precision
from grazing_checker.envelope import LARGEST, VALUES
from grazing_checker.flight import Checked, Motion, Work
from tests.grazing_checker.bases import bases
from tests.grazing_checker.documents import changed, claiming, documents, resealed
from tests.grazing_checker.truth import is_true
from tests.proof.orbits import closed


@pytest.mark.parametrize(
    "inside", ["1e999", "-1e999", "9" * 400 + ".0", *("[" * n + "]" * n for n in (950, 990, 5000))]
)
@pytest.mark.parametrize("field", ["data", "statement", "format", "version", "kind"])
def test_json_that_can_be_read_but_not_written_is_rejected(tmp_path, inside, field):
    document = {**documents()["free"], field: {"x": "@"} if field == "data" else "@"}
    path = tmp_path / "c.json"
    path.write_text(json.dumps(document).replace('"@"', inside))
    with pytest.raises(Rejected):
        check(path)
    assert main([str(path)]) == 1


def test_an_orbit_that_is_lifted_off_is_stable_only_if_slow_impacts_stay_slow():
    """With w = 0 a motion beside the orbit meets the wall slowly once more: a law that kicks it throws it off."""
    model = gz.Oscillator(0.3, 1.0, gz.Forcing(omega=2.2, offset=0.2, cos=(1.0,)), gz.newton(r=0.0))
    (orbit,) = gz.one_impact_orbits(model, 1)
    good = certify(orbit)
    assert good.claims["stability"] == "stable" and check(good.document) == good.statement
    fast = ["<", "v", (-0.01).hex()]
    kicking = {"parameters": {}, "after": ["if", fast, (0.0).hex(), (0.5).hex()]}
    forged = claiming(changed(good.document, ("data", "law"), lambda _old: kicking))
    with pytest.raises(Rejected, match="throw slow impacts back"):
        check(forged)
    gentle = {"parameters": {}, "after": ["if", fast, (0.0).hex(), ["*", (-0.5).hex(), "v"]]}
    other = claiming(changed(good.document, ("data", "law"), lambda _old: gentle))
    assert check(other).endswith("inside the unit circle.")
    sinking = {"parameters": {}, "after": ["if", fast, (0.0).hex(), ["*", (0.5).hex(), "v"]]}  # into the wall
    with pytest.raises(Rejected, match="throw slow impacts"):
        check(claiming(changed(good.document, ("data", "law"), lambda _old: sinking)))
    no_speed = (0.0).hex()
    for back in ((0.5).hex(), ["*", (0.5).hex(), ["^", ["-", "v"], (0.5).hex()]]):  # it throws back what has any speed
        after = ["if", fast, no_speed, ["if", ["<", "v", no_speed], back, no_speed]]
        forged = changed(good.document, ("data", "law"), lambda _old, after=after: {"parameters": {}, "after": after})
        with pytest.raises(Rejected, match="throw slow impacts back"):
            check(claiming(forged))
    kicked = gz.reset(lambda v, p: 0.0 * v if v < -p.slow else 0.5 + 0.0 * v, slow=0.01)
    found = certify(_with(orbit, gz.Oscillator(0.3, 1.0, model.forcing, kicked)))
    assert found.proven and found.claims["stability"] == "undecided"
    assert "throw back" in found.reason and check(found.document) == found.statement


def test_between_walls_it_is_the_wall_that_is_left_with_w_0_whose_law_is_asked():
    """The other one may throw slow impacts back as it likes: none come there."""
    good = documents()["caught"]
    hits, claims = good["data"]["impacts"], good["data"]["claims"]
    assert claims["stability"] == "stable" and float(claims["box"][2 + hits.index("B")][0]) < 1e-20
    slow, back = [">", "v", (-0.01).hex()], (0.5).hex()

    def kicking(law):
        return {**law, "after": ["if", slow, back, law["after"]]}

    forged, other = (changed(good, ("data", "walls", j, "law"), kicking) for j in (1, 0))
    with pytest.raises(Rejected, match="throw slow impacts back"):
        check(claiming(forged))
    assert check(claiming(other)).endswith("inside the unit circle.")
    assert is_true(forged["kind"], forged["data"]) == (False, "slow impacts beside one that leaves with w = 0 are not")
    assert is_true(other["kind"], other["data"]) == (True, "")


def _with(orbit, model):
    """The same numbers as an orbit of another model."""
    return closed(model, orbit.period, orbit.times, orbit.outgoing, orbit.incoming)[0]


@pytest.mark.parametrize("kind", ["pd", "gr", "lp", "ns"])
def test_a_curve_is_said_to_be_alone_nowhere_but_in_what_was_proven(kind):
    """The box printed is rounded outwards, up to 2^-30 of its size: uniqueness is proven in a smaller one."""
    statement = documents()[kind]["statement"]
    assert "alone" not in statement
    grows = {"pd": "p.V", "gr": "d", "lp": "t_1", "ns": "p.r"}[kind]
    assert f"the curve is one of such orbits in that box, along which {grows} grows, and they stay off" in statement


def test_a_value_says_no_more_than_its_multiplier_or_its_height():
    """No normal form is proven, and beyond a graze the orbits of the curve are none of the oscillator."""
    for kind in ("pd", "lp", "ns"):
        assert "(as at a " in documents()[kind]["statement"]
    free = "stay off the wall between their impacts but for that dip, in which they are continued as if there were no"
    assert free in documents()["gr"]["statement"]


def test_orbits_of_the_gap_map_that_meet_0_are_spoken_of_apart():
    """They have no multiplier: the slope of the root is infinite there."""
    statement = bases()["small"]["statement"]
    assert statement.endswith("modulus above 1, or meets 0, where the slope of its letter R is infinite.")


MEASURED = """
import os, sys; sys.set_int_max_str_digits(0)
if child := os.fork():  # what exec makes begins with the peak of the process that started it, what fork makes does not
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
from resource import getrusage, RUSAGE_SELF
from grazing_checker.__main__ import main
from grazing_checker.balls import number, precision
before = getrusage(RUSAGE_SELF); main(sys.argv[1:]); after = getrusage(RUSAGE_SELF)
print(after.ru_maxrss - before.ru_maxrss, after.ru_utime - before.ru_utime)
with precision(1024):
    x = y = number(1) / 3
    for _ in range(200_000):
        y = (y * x + x) * x
print(getrusage(RUSAGE_SELF).ru_utime - after.ru_utime)
"""


def measured(path):
    """What is said of a file, its memory in bytes, seconds of the processor, and those of 600,000 sums and products."""
    done = subprocess.run([sys.executable, "-c", MEASURED, path], capture_output=True, text=True)
    memory, time, yard = done.stdout.split()[-3:]
    return done.stderr, int(memory) * (1 if sys.platform == "darwin" else 1024), float(time), float(yard)


HOSTILE = {
    "periods": {("periods",): 10_000},
    "rates": {("model", "k"): (1e5).hex(), ("precision",): 1024},
    "impacts": {("impacts",): 900, ("claims", "box"): [["0", "0"]] * 1800},
    "precise": {("periods",): 800, ("precision",): 1024},
    "memory": {("periods",): 1050, ("precision",): 1024},  # as many steps as the work allows, all of them in one flight
    "slow": {("model", "omega"): (1e-5).hex()},
    "harmonics": {("periods",): 10, ("model", "cos"): [(1e-3).hex()] * 1000, ("model", "sin"): [(1e-3).hex()] * 1000},
}


def test_flights_to_two_walls_take_no_more_memory_than_those_to_one(tmp_path):
    """As many steps to each wall as one wall may have."""
    forged, path = documents()["pair"], tmp_path / "c.json"
    for place, new in {("precision",): 1024, ("periods",): 1550}.items():
        forged = changed(forged, ("data", *place), lambda _old, new=new: new)
    forged["data"]["centre"][1] = "0x1307p0"  # 4871, half of 1550 periods after the first
    path.write_text(json.dumps(claiming(forged)))
    refusal, memory, _time, _yard = measured(path)
    assert "too much work" in refusal and memory < 16 * LARGEST


@pytest.mark.parametrize("name", HOSTILE)
def test_a_certificate_that_keeps_the_checker_busy_is_rejected_before(tmp_path, name):
    forged = documents()["free"]
    for path, new in HOSTILE[name].items():
        forged = changed(forged, ("data", *path), lambda _old, new=new: new)
    path = tmp_path / "c.json"
    path.write_text(json.dumps(claiming(forged)))
    refusal, memory, time, yard = measured(path)
    assert "too much work" in refusal
    # half a minute where 600,000 sums and products of 1024 bits take a fifth of a second, however slow this machine is
    assert memory < 16 * LARGEST and time < 150.0 * yard


def test_work_is_counted_over_a_whole_certificate():
    work = Work()
    work.spend(work.left)
    with pytest.raises(Rejected, match="too much work"):
        work.spend(1)


@pytest.mark.parametrize("size", [-3000, -1080, 0, 900])
def test_the_bound_of_the_rest_holds_in_any_unit(size):
    """Smaller than the smallest double, all bounds are one number to a float: the largest is to be taken."""
    with precision(256):
        tiny, one = number(1, size), number(1)
        motion = Motion(one, one, one, number(0), number(0), number(0), [tiny], [number(0)], {})
        flights = Checked(motion)
        series = flights.expanded(number(0), number(0), number(0))
        assert series.C >= flights.A / flights.room
        for n in (flights.K - 2, flights.K - 1):
            size_n = abs(series.terms[n]) * arb(n + 1).gamma() / series.rho**n
            assert series.C >= size_n


def test_the_name_of_a_file_need_not_be_text(tmp_path):
    path = tmp_path / "\udcff.json"
    path.write_text(json.dumps(documents()["free"]))
    done = subprocess.run(
        [sys.executable, "-m", "grazing_checker", path],
        capture_output=True,
        text=True,
        encoding="ascii",
        errors="replace",
    )
    assert done.returncode == 0 and "For the oscillator" in done.stdout


#: A line that pretends to be a certificate that passed.
LIE = "\x1b[2J\r\ngood.json: For lam = 0.5 every orbit is stable.\u202e"


def _places(document):
    """The document with the lie as a key or a value, wherever one can be put."""
    for path in [(), ("data",), ("data", "claims"), ("inequalities", 0)]:
        inner = document
        for step in path:
            inner = inner[step]
        yield {**document, LIE: 1} if not path else changed(document, path, lambda old: {**old, LIE: 1})
        for key in inner:
            if path or key in ("kind", "statement"):  # the others are made anew as it is sealed
                yield changed(document, (*path, key), lambda _old: LIE)


@pytest.mark.parametrize("name", ["R", "stable"])
def test_a_message_about_a_certificate_is_one_line_whatever_it_quotes(name):
    for forged in _places(bases()[name]):
        for document in (forged, resealed(forged) if set(forged) <= set(bases()[name]) else forged):
            with pytest.raises(Rejected) as refusal:
                check(document)
            assert str(refusal.value).isprintable()


def test_a_message_quotes_no_more_than_can_be_read():
    long = "x" * 10**6
    row = [("inequalities", 0, key) for key in ("name", "left", "relation", "right")]
    for path in (("data", "word"), ("data", "lam"), *row, ("kind",), ("statement",)):
        with pytest.raises(Rejected) as refusal:
            check(resealed(changed(bases()["R"], path, lambda _old: long)))
        assert len(str(refusal.value)) < 1000
    more = {f"{long}{i}": i for i in range(9)} | {f"key {i}": i for i in range(10_000)}
    orbit, at = bases()["stable"], ("data", "claims", "stability")
    for forged in (
        changed(bases()["R"], ("data",), lambda old: {**old, **more}),
        changed(orbit, at, lambda _old: long),
    ):
        with pytest.raises(Rejected) as refusal:
            check(resealed(forged))
        assert len(str(refusal.value)) < 1000
    for forged in ({**bases()["R"], **more}, {**bases()["R"], "version": long}, {"format": long}):
        with pytest.raises(Rejected) as refusal:
            check(forged)
        assert len(str(refusal.value)) < 1000


@pytest.mark.parametrize("name", ["a\nb", "good.json: For lam = 0.5 every orbit is stable.", "'; x", "\x1b[2J", LIE])
def test_the_name_of_a_file_cannot_be_taken_for_a_sentence(tmp_path, monkeypatch, capsys, name):
    """A name with more than letters, digits and marks of paths is quoted, on the line of what is proven."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(json.dumps(bases()["R"]))
    assert main([name, name + "none"]) == 1
    said, refused = capsys.readouterr()
    assert said == f"{name!r}: {bases()['R']['statement']}\n"
    assert refused.startswith(f"{name + 'none'!r}: rejected: ") and refused[:-1].isprintable()


#: What files of the largest size hold as their data, and what is said of them; numbers of any length may be read.
FILES = {
    "lists": ("[", "[],", "0]", "more than 524288 values"),
    "mappings": ("[", '{"a":1},', "0]", "more than 524288 values"),
    "keys": ('{"b":0', ',"a":1', "}", "more than 524288 values"),
    "deep": ("", "[", "", "more than 524288 values"),
    "whole": ("", "9", "", "a number has 1677"),
    "fraction": ("0.", "9", "", "a number has 1677"),
    "exponent": ("1e", "9", "", "a number has 1677"),
    "text": ('"', "x", '"', "changed after it was sealed"),
    "wide": ('"', "\U0001f600", '"', "changed after it was sealed"),
}


def hostile_file(path, before, piece, after):
    document = json.dumps({**bases()["R"], "data": {"x": "@"}}).split('"@"')
    left = LARGEST - len("".join(document)) - 100
    path.write_text(f"{before}{piece * (left // len(piece.encode()))}{after}".join(document), encoding="utf-8")
    assert LARGEST - 200 < path.stat().st_size <= LARGEST
    return path


@pytest.mark.parametrize("name", FILES)
def test_the_largest_file_is_refused_before_it_takes_memory_or_time(tmp_path, name):
    *pieces, said = FILES[name]
    refusal, memory, time, _yard = measured(hostile_file(tmp_path / "c.json", *pieces))
    assert said in refusal and "Traceback" not in refusal
    assert memory < 16 * LARGEST and time < 5.0


@pytest.mark.parametrize("piece", ["[],", '{"a":1},', '{"a":{"a":[]}},'])
def test_the_most_values_that_are_read_fit_into_memory(tmp_path, piece):
    path = tmp_path / "c.json"
    document = json.dumps({**bases()["R"], "data": {"x": "@"}}).split('"@"')
    marks = sum(map("".join(document).count, ",[{"))
    path.write_text(f"[{piece * ((VALUES - marks - 1) // sum(map(piece.count, ',[{')))}0]".join(document))
    refusal, memory, time, _yard = measured(path)
    assert "changed after it was sealed" in refusal
    assert memory < 16 * LARGEST and time < 5.0


@pytest.mark.parametrize("levels", [400, 900, 20_000])
def test_lists_in_lists_are_refused_in_words(tmp_path, levels):
    path = tmp_path / "c.json"
    document = json.dumps({**bases()["R"], "data": {"x": "@"}}).split('"@"')
    path.write_text(("[" * levels + "]" * levels).join(document))
    with pytest.raises(Rejected, match=r"too deep in each other|changed after it was sealed"):
        check(path)


NUMBERS = {
    "exact": ("0x1p99999", "0x1p-99999999", "0x1p" + "9" * 10**6, "0x" + "f" * 601 + "p0", "0x" + "f" * 10**6 + "p0"),
    "double": ("0x1p99999999", "0x1." + "0" * 10**6 + "p+0", "1" * 10**6),
    "decimal": ("1E99999", "1E-99999999", "9" * 61, "0." + "9" * 10**6),
}
PLACES = {
    "exact": [("data", "centre", 0), ("data", "radius"), ("data", "unique")],
    "double": [("data", "lam"), ("data", "mu"), ("data", "preconditioner", 0, 0)],
    "decimal": [("inequalities", 0, "left"), ("data", "claims", "apart"), ("data", "claims", "multiplier", 0)],
}


@pytest.mark.parametrize("form", NUMBERS)
def test_a_number_of_great_length_or_exponent_is_refused_as_it_is_read(form):
    for text in NUMBERS[form]:
        for path in PLACES[form]:
            forged = resealed(changed(bases()["R"], path, lambda _old, text=text: text))
            before = process_time()
            with pytest.raises(Rejected, match=f"is no (finite )?{form}"):
                check(forged)
            assert process_time() - before < 2.0
