"""One orbit of a one-dimensional map: steps that pass by are cut into parts, counted, and change nothing."""

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import FATAL
from grazing.studies import cobweb as module
from grazing.studies.cobweb import cobweb


@pytest.mark.parametrize(("mu", "start"), [(0.1, 0.05), (1e-3, 0.0), (1e300, -1e308)])
def test_a_transient_in_parts_is_the_transient_and_is_counted(monkeypatch, mu, start):
    """A billion steps took a minute without a word."""
    G, counted = gz.gap_map(lam=-2.0 if mu > 1.0 else 0.5, mu=mu, l=0.1), []
    whole = cobweb(G, [start], steps=4, transient=52)
    monkeypatch.setattr(module, "TOGETHER", 8)
    parts = cobweb(G, [start], steps=4, transient=52, progress=lambda *done: counted.append(done))
    ended = bool((parts.outcome.values & FATAL).any())
    assert ended == bool((whole.outcome.values & FATAL).any()) == (mu > 1.0)
    if ended:
        np.testing.assert_array_equal(parts.outcome & FATAL, whole.outcome & FATAL)
    else:
        assert parts.identical(whole)
        assert counted == [(8 * k, 56) for k in range(1, 7)]
