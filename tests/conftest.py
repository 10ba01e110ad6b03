"""What every test shares: Hypothesis' examples, and collection that costs little."""

import gc
import signal

import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings

from tests.examples import ALL

# The same examples on every machine, and no deadline, since a first call may compile.
settings.register_profile("thorough", deadline=None, derandomize=True, max_examples=ALL)
settings.register_profile("quick", settings.get_profile("thorough"), max_examples=ALL // 5)
settings.load_profile("quick")

# A shell lets what it starts in the background ignore Ctrl-C, and all that this starts: tests send it, and wait.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# What collection makes stays until the end: searching it for rubbish again and again is a quarter of its time.
gc.disable()


def pytest_collection_finish():
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)  # a test's objects are few beside what it imports: seldom is often enough
    gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_collect_file():
    """Look for no examples in the documentation strings of tests: there are none, and to look takes a second."""
    return [found for found in (yield) if not isinstance(found, DoctestModule)]
