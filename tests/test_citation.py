"""What to cite."""

import re
from pathlib import Path

import pytest

import grazing
from grazing import cite

CFF = (Path(__file__).parents[1] / "CITATION.cff").read_text(encoding="utf-8")


@pytest.mark.parametrize("style", ["bibtex", "text"])
def test_both_the_software_and_the_paper_are_named(style):
    text = cite(style)
    for part in (grazing.__version__, "grazing: oscillators" if style == "bibtex" else "grazing, oscillators",
                 "The dynamics of a simplified pinball machine", "76", "2011"):  # fmt: skip
        assert part in text
    assert text.endswith("\n") and not text.endswith("\n\n")


def test_bibtex_is_the_default_and_its_braces_match():
    text = cite()
    assert text == cite("bibtex")
    assert re.findall(r"^@(\w+)\{(\w+),$", text, re.MULTILINE) == [("misc", "grazing"), ("article", "PringBudd2011")]
    for entry in text.split("\n\n"):
        depth = 0
        for letter in entry:
            depth += {"{": 1, "}": -1}.get(letter, 0)
            assert depth >= 0
        assert depth == 0


def test_it_says_the_same_as_the_citation_file():
    for field in ("title", "journal", "volume", "start", "end", "year"):
        for value in re.findall(rf"^ *{field}: \"?([^\"\n]+)\"?$", CFF, re.MULTILINE):
            assert value in cite()


def test_an_unknown_style_is_refused():
    with pytest.raises(grazing.InputError, match=r"style is 'apa'; allowed are 'bibtex' and 'text'"):
        cite("apa")
