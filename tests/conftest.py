"""One hypothesis profile: the same examples on every machine, and no deadline, since a first call may compile."""

from hypothesis import settings

settings.register_profile("grazing", deadline=None, derandomize=True)
settings.load_profile("grazing")
