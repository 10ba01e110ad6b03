import os
from fractions import Fraction
from pathlib import Path

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from grazing.outcome import InputError
from grazing.proof.text import about, above, below, enclosed, exact_text, short, write_certificate
from grazing_checker.reading import Rejected, decimal, exact, text_of_double

NUMBERS = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e100, max_value=1e100)


@given(NUMBERS, st.integers(-300, 300))
def test_exact_texts_come_back_exactly(x, e):
    ball = arb(x) * arb(2) ** e
    assert (exact(exact_text(ball)) - ball).is_zero()


@given(NUMBERS, st.integers(1, 25))
def test_decimals_are_rounded_to_the_safe_side_and_by_no_more_than_they_must(x, digits):
    number = Fraction(x)
    low, high = (Fraction(text) for text in (below(arb(x), digits), above(arb(x), digits)))
    assert low <= number <= high
    assert high - low <= abs(number) * Fraction(10) ** (1 - digits)


@given(NUMBERS, st.floats(0.0, 1e3))
def test_enclosures_hold_the_ball(x, r):
    ball = arb(x, r)
    low, high = (decimal(text) for text in enclosed(ball))
    assert low <= ball.lower() or low.overlaps(ball.lower())
    assert high >= ball.upper() or high.overlaps(ball.upper())


@given(NUMBERS, st.floats(1e-30, 1e3))
def test_a_middle_and_a_reach_hold_the_interval(x, r):
    low, high = enclosed(arb(x, r), 24)
    middle, reach = map(Fraction, about(low, high).split(" to within "))
    assert middle - reach <= Fraction(low) and Fraction(high) <= middle + reach
    assert reach <= Fraction(11, 10) * (Fraction(high) - Fraction(low)) / 2 + abs(Fraction(low)) / 10**13


def test_short_numbers_have_so_many_bits():
    with ctx.workprec(200):
        third = short(arb(1) / 3, 24)
        assert int(third.man_exp()[0]).bit_length() <= 24
        assert abs(third - arb(1) / 3) < arb(2) ** -24


@pytest.mark.parametrize(
    "text", ["", "1p0", "0x1", "0X1p0", "0x1p0 ", "0x1.8p0", "+0x1p0", "0x1p1e3", None, 1, "0xgp0"]
)
def test_what_is_no_exact_number_is_rejected(text):
    with pytest.raises(Rejected, match="no exact number"):
        exact(text)


@pytest.mark.parametrize("text", ["", "nan", "1e", "0x1p0", "inf", " 1", None, 1.5, "1.", "1_0"])
def test_what_is_no_decimal_is_rejected(text):
    with pytest.raises(Rejected, match="no decimal"):
        decimal(text)


@pytest.mark.parametrize("text", ["0x1p0", "inf", "nan", "1.5", "0x1.0p+0", None, 3])
def test_what_is_no_double_as_python_writes_it_is_rejected(text):
    with pytest.raises(Rejected):
        text_of_double(text)


def test_a_certificate_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    """A full disk left half of it in the place of the old one; links were followed, pipes replaced."""
    file, other = tmp_path / "a.json", tmp_path / "other"
    other.write_text("precious")
    write_certificate({"a": 1}, file)
    before = file.read_bytes()
    real = Path.write_text

    def full(self, text, **options):
        real(self, text[:3], **options)
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(InputError, match="cannot be written: No space left"):
        patch.setattr(Path, "write_text", full)
        write_certificate({"a": 2}, file)
    assert file.read_bytes() == before and {path.name for path in tmp_path.iterdir()} == {"a.json", "other"}
    with pytest.raises(InputError, match="is a folder"):
        write_certificate({"a": 2}, tmp_path)
    with pytest.raises(InputError, match="cannot be written"):
        write_certificate({"a": 2}, tmp_path / "nowhere" / "a.json")
    file.unlink()
    file.symlink_to(other)
    write_certificate({"a": 1}, file)
    assert file.read_bytes() == before and other.read_text() == "precious" and not file.is_symlink()
    if hasattr(os, "mkfifo"):
        file.unlink()
        os.mkfifo(file)
        with pytest.raises(InputError, match="is a pipe, which a file would replace"):
            write_certificate({"a": 1}, file)
        assert file.is_fifo()
