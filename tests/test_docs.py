"""The documentation does what it says: its code runs, its commands exist, its links lead somewhere."""

import importlib.util
import re
import shlex
import sys
import types
from pathlib import Path

import pytest

import grazing
from grazing.cli import main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(!?)\[[^\]]*\]\(([^)\s]+)\)")


#: Pages whose comments are what their lines print, with those that say what it is instead.
PRINTED = {"si-units": ["c/m, k/m, -force/m, -gap"], "road": [], "exercises": []}


def read(page):
    return page.read_text(encoding="utf-8")


def blocks(page, *languages):
    return [(text, read(page)[: m.start()].count("\n") + 2) for m in BLOCK.finditer(read(page))
            for language, text in [m.groups()] if language in languages]  # fmt: skip


def load(file):
    spec = importlib.util.spec_from_file_location(f"_{file.stem}", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def make_api():
    return load(ROOT / "docs" / "make_api.py")


def name_of(page):
    return page.relative_to(ROOT).as_posix()


# ---- code


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=name_of)
def test_code_runs_when_pasted(page, tmp_path, monkeypatch, capsys):
    # One session per page, as a reader would paste it, in a folder of its own.
    monkeypatch.chdir(tmp_path)
    session = types.ModuleType("session")
    monkeypatch.setitem(sys.modules, "session", session)  # as __main__ is: kernels on the disk say where they are from
    for text, line in blocks(page, "python"):
        # leading newlines: an error names its line in the page
        exec(compile("\n" * (line - 1) + text, str(page), "exec"), session.__dict__)
    out = capsys.readouterr().out
    assert out
    assert list(tmp_path.iterdir()) == []
    if page.stem in PRINTED:
        text = "\n".join(text for text, _line in blocks(page, "python"))
        said = [line.split(")  # ", 1)[1] for line in text.splitlines() if ")  # " in line and "print(" in line]
        missing = [comment for comment in said if comment not in ", ".join(out.splitlines())]
        assert missing == [comment for comment in said if comment in PRINTED[page.stem]] and len(said) > len(missing)
    for raw in ("np.str_(", "np.float64(", "np.int32(", " object at 0x"):
        assert raw not in out, f"{name_of(page)} prints {raw}"


def test_the_readme_shows_what_it_says(capsys):
    (text, _line) = blocks(ROOT / "README.md", "python")[0]
    assert len(text.splitlines()) <= 14
    session = {}
    exec(text, session)
    assert "lam=0.336482, l=0.649353" in capsys.readouterr().out
    assert (session["diagram"].period.sel(d=0.12, method="nearest") == 3).all()
    assert f"{session['exact'].high.values[-1]:.10f}" in read(ROOT / "README.md")
    nf = session["nf"]
    assert f"{nf.parameter(grazing.theory.mu_pd(7, nf.lam, nf.l)):.10f}" in read(ROOT / "README.md")
    assert f"{nf.graze:.12f}" in read(ROOT / "README.md")


def test_the_table_of_the_paper_page_is_what_its_code_prints(capsys):
    page = ROOT / "docs" / "paper.md"
    exec(blocks(page, "python")[0][0], {})
    for line in capsys.readouterr().out.splitlines():
        N, low, low_predicted, high, high_predicted = line.split()
        assert f"| {N} | {low} | {low_predicted} | {high} | {high_predicted} |" in read(page)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_names_in_the_text_exist(page):
    for dotted in set(re.findall(r"\bgz((?:\.[A-Za-z_]\w*)+)", read(page))):
        value = grazing
        for name in dotted[1:].split("."):
            assert hasattr(value, name), f"{name_of(page)} names gz{dotted}"
            value = getattr(value, name)


# ---- commands


def commands(page):
    for text, _line in blocks(page, "console", "sh"):
        for line in text.splitlines():
            tokens = shlex.split(line.removeprefix("$ "), comments=True)
            if tokens:
                yield tokens


def ours(tokens):
    """The arguments of grazing in a command line, or None."""
    if tokens[0] == "grazing":
        return tokens[1:]
    if Path(tokens[0]).name.startswith("python") and tokens[1:3] == ["-m", "grazing"]:
        return tokens[3:]
    return None


COMMANDS = [(page, tokens) for page in PAGES for tokens in commands(page)]


@pytest.mark.parametrize(("page", "tokens"), [(p, t) for p, t in COMMANDS if ours(t) is not None])
def test_commands_run(page, tokens, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = ours(tokens)
    if arguments[:1] == ["paper"]:  # the same command, but quick and in a folder of its own
        quick = {"--out": str(tmp_path / "out"), "--size": "small", "--figures": "3.1"}
        arguments += [token for option in quick.items() if option[0] not in arguments for token in option]
    assert main(arguments) == 0, capsys.readouterr().err


def test_targets_of_make_exist():
    makefile = read(ROOT / "Makefile")
    named = [tokens[1] for _page, tokens in COMMANDS if tokens[0] == "make"]
    assert {"paper", "test"} <= set(named)
    assert all(re.search(rf"^{target}:", makefile, re.MULTILINE) for target in named)


# ---- links, images, reference


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page, make_api):
    text = re.sub(r"```.*?```|`[^`\n]*`|^    [^\n]*$", "", read(page), flags=re.DOTALL | re.MULTILINE)
    for image, target in LINK.findall(text):
        if target.startswith("https://"):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_relative_to(ROOT), f"{target} leaves the project"
        assert file.is_file(), f"{name_of(page)} links to {target}"
        if anchor:
            assert anchor in [slug for _heading, slug in make_api.anchors(read(file))], f"{name_of(page)}: {target}"
        if image:
            assert file.stat().st_size < 300_000
            assert file.read_bytes().startswith(b"\x89PNG")


def test_every_page_is_reached_from_the_contents():
    linked = {target.partition("#")[0] for _image, target in LINK.findall(read(ROOT / "docs" / "index.md"))}
    assert {page.name for page in PAGES if page.parent.name == "docs"} - {"index.md"} <= linked
    assert {f"../examples/{file.name}" for file in (ROOT / "examples").glob("*.py")} <= linked


def test_the_reference_is_current(make_api):
    assert read(make_api.PAGE) == make_api.page(), "run python docs/make_api.py"
    assert read(make_api.COMMANDS) == make_api.commands(), "run python docs/make_api.py"


def test_the_reference_has_every_public_name(make_api):
    text = read(make_api.PAGE)
    for name in grazing.__all__:
        if not name.startswith("_") and not isinstance(getattr(grazing, name), types.ModuleType):
            assert f"\n### {name}\n" in text
    assert ":func:" not in text and ":class:" not in text
    assert not re.search(r"\w -{4,} ", text), "a heading in a documentation string is run into its text"


def test_the_reference_can_be_checked_from_the_shell(make_api, tmp_path, monkeypatch, capsys):
    assert make_api.main(["--check"]) == 0
    monkeypatch.setattr(make_api, "PAGE", tmp_path / "api.md")
    assert make_api.main(["--check"]) == 1
    assert make_api.main([]) == 0
    assert make_api.main(["--check"]) == 0
    assert make_api.main(["--chekc"]) == 2
    assert "--check" in capsys.readouterr().err


# ---- examples


def test_example_passive_and_active(tmp_path):
    out = tmp_path / "figure.png"
    shares = load(ROOT / "examples" / "passive_and_active.py").main(
        ["--values", "23", "--starts", "5", "--out", str(out)]
    )
    assert shares == {0.0: {2: 1.0}, 0.4: {3: 1.0}}
    assert out.read_bytes().startswith(b"\x89PNG")


def example(name, tmp_path, *tokens):
    """Run an example at a reduced size; return what it returns, and check the figure it wrote."""
    out = tmp_path / f"{name}.png"
    found = load(ROOT / "examples" / f"{name}.py").main([*tokens, "--out", str(out)])
    assert out.read_bytes().startswith(b"\x89PNG")
    return found


def test_example_hysteresis(tmp_path):
    differ = example("hysteresis", tmp_path, "--values", "60")
    # the orbits differ in the three overlaps of windows, and nowhere else
    overlaps = [(0.0984, 0.1034), (0.1219, 0.1236), (0.1282, 0.1288)]
    assert all(any(low < d < high for low, high in overlaps) for d in differ)
    assert any(overlaps[0][0] < d < overlaps[0][1] for d in differ)


def test_example_chart_with_theory(tmp_path):
    several = example("chart_with_theory", tmp_path, "--size", "12")
    assert 0.0 < several < 0.5


def test_example_coexisting_basins(tmp_path):
    fractions = example("coexisting_basins", tmp_path, "--size", "40")
    assert fractions.keys() == {"01", "001"}
    assert sum(fractions.values()) == pytest.approx(1.0)


def test_example_robust_chaos(tmp_path):
    shares = example("robust_chaos", tmp_path, "--values", "60")
    assert shares[0.0] > 2 * shares[0.5] > 0.0


def test_example_stable_doubling(tmp_path):
    found = example("stable_doubling", tmp_path, "--values", "12")
    assert found["share"] > 0.9 and found["apart"] < 1e-9


def test_example_manifolds(tmp_path):
    assert example("manifolds", tmp_path, "--size", "40", "--length", "0.5").keys() == {"01", "001"}


def test_example_ladder(tmp_path):
    orders, same = example("ladder", tmp_path, "--periods", "6", "--size", "12")
    assert orders and 0.0 < same <= 1.0


def test_example_bouncing_ball(tmp_path):
    doubling, exact = example("bouncing_ball", tmp_path, "--values", "12")
    assert abs(doubling - exact) < 1e-9


def test_example_gear_rattle(tmp_path):
    assert example("gear_rattle", tmp_path, "--values", "12") > 0.5


def test_example_road(tmp_path):
    found = example("road", tmp_path, "--points", "4")
    assert list(found) == [(name, V) for name, kick in (("classic", 8.0), ("one bumper", 8.0), ("returned", 0.3),
                                                        ("oscillator", 0.2)) for V in (0.0, kick)]  # fmt: skip
    said = [line.strip("|").split(" | ") for line in read(ROOT / "docs" / "road.md").splitlines()]
    rows = [[float(x.strip(" |").replace("−", "-")) for x in cells[1:]] for cells in said
            if len(cells) == 6 and cells[1] != "kick"]  # fmt: skip
    for (measured, predicted), row in zip(found.values(), rows, strict=True):
        assert predicted == pytest.approx(measured, rel=2e-5, abs=1e-8)
        assert [*measured, *predicted] == pytest.approx([row[1], row[3], row[2], row[4]], rel=1e-4, abs=1e-8)


def known(found, factor):
    """Say whether exponents of a Galton board and the constant of Sinai billiards are what they should tend to."""
    constants, grown = found
    constant = load(ROOT / "examples" / "known_billiards.py").CONSTANT
    near, far = (constants[R] for R in (min(constants), max(constants)))
    assert abs(near[0] - constant) < 3.0 * near[1] < 0.5 * (far[0] - constant)
    for name, law in (("speed", 1 / 3), ("fall", 2 / 3)):
        powers, errors = grown[name]
        assert abs(powers[-1] - law) < 3.0 * errors[-1] < factor * law
    return True


def test_example_known_billiards(tmp_path):
    assert known(example("known_billiards", tmp_path, *"--radii 0.1 0.01 --hits 80 --balls 40 --until 30".split()), 1.0)


@pytest.mark.long
def test_example_known_billiards_to_smaller_errors(tmp_path):
    assert known(example("known_billiards", tmp_path, *"--radii 0.1 0.003 --hits 1500 --balls 600".split()), 0.2)


def test_example_own_reset_law():
    seen = load(ROOT / "examples" / "own_reset_law.py").main()
    assert [sum(letters) for letters in seen.values()] == [3, 3, 4]


def test_example_shallow_impacts():
    example = load(ROOT / "examples" / "shallow_impacts.py")
    example.DEPTHS = (1e-1, 1e-6)
    shares = example.main(["--count", "12"])
    assert shares["grazing"] == [1.0, 1.0]
    assert all(row[0] == 1.0 and row[1] < 0.5 for name, row in shares.items() if name != "grazing")


def test_the_table_of_the_readme_is_that_of_the_example():
    example = load(ROOT / "examples" / "shallow_impacts.py")
    rows = {cells[0].strip(): cells[1:] for line in read(ROOT / "README.md").splitlines()
            if len(cells := line.strip("|").split("|")) == 6}  # fmt: skip
    depths = next(cells for name, cells in rows.items() if name.startswith("depth"))
    assert {float(depth) for depth in depths} <= set(example.DEPTHS)
    assert {*example.SOLVERS, "grazing"} <= rows.keys()
    assert [float(share) for share in rows["grazing"]] == [1.0] * 5
