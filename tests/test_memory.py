"""A result that would not fit is refused before it is begun, in words."""

import os

import pytest

from grazing import memory
from grazing.memory import physical_memory, refuse_too_large
from grazing.outcome import InputError


def test_the_memory_of_this_machine():
    size = physical_memory()
    assert size is None or size > 2**26


@pytest.mark.parametrize("error", [AttributeError, OSError, ValueError])
def test_a_system_that_does_not_say_refuses_nothing(monkeypatch, error):
    def silent(name):
        raise error(name)

    monkeypatch.setattr(os, "sysconf", silent, raising=False)
    assert physical_memory() is None
    refuse_too_large(2**80, "reduce it")


def test_half_of_the_memory_is_the_limit(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 2_000_000_000)
    refuse_too_large(1_000_000_000, "reduce it")
    with pytest.raises(InputError) as refused:
        refuse_too_large(1_000_000_001, "reduce it")
    assert str(refused.value) == ("the result would take 1 GB, more than half of the memory (2 GB); reduce it")


def test_the_limit_of_a_process_is_memory_too(monkeypatch):
    """``ulimit -v``: what was foreseen to fit ended in an error of the machine."""
    monkeypatch.setattr(memory, "physical_memory", lambda: None)
    monkeypatch.setattr(memory, "address_space", lambda: 2_000_000_000)
    with pytest.raises(InputError, match=r"more than half of the memory \(2 GB\)"):
        refuse_too_large(1_000_000_001, "reduce it")
