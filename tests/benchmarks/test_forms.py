"""What each wide form brings is said form by form."""

import io

from rich.console import Console

from benchmarks import forms
from grazing.kernel.wide import forms as listed
from grazing.kernel.wide import plain


def test_every_wide_form_is_left_out_once():
    named = [name for left_out in forms.WAYS.values() for name in left_out or ()]
    wide = sorted(each.__name__ for each in listed() if each.__module__ != "grazing.kernel.primitives")
    assert plain() or sorted(named) == wide


def test_a_way_serves_its_work():
    process = forms.started(("transposed",), 0.02)
    try:
        assert forms.answer(process) == "ready"
        for work in forms.WORK:
            forms.ask(process, work)
            assert float(forms.answer(process)) > 0.0
        forms.ask(process, "")
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.communicate()


def test_what_was_measured_is_shown():
    out = io.StringIO()
    forms.show_forms(Console(file=out), [forms.Brought("without transposed", dict.fromkeys(forms.WORK, 1.104))])
    assert "| without transposed | 1.10 | 1.10 | 1.10 | 1.10 |" in out.getvalue()
