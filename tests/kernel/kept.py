"""A kernel for tests of what the disk keeps."""

from grazing.kernel.compile import compiled

SOURCE = "def outer(x):\n    return {factor} * x + 1.0\n"


def fresh(factor=2.0):
    """The same kernel as a new function, as another process has it: only the disk knows it."""
    names = {"__name__": __name__}
    exec(SOURCE.format(factor=factor), names)
    return compiled(names["outer"])
