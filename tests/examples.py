"""How many examples of a property Hypothesis tries: all of them in ``make test-long``, a fifth in ``make test``."""

from hypothesis import settings

ALL = 100


def examples(number):
    """Return how many to try where a test wants another number than usual; decided by the profile that is loaded."""
    return max(number * settings().max_examples // ALL, 1)
