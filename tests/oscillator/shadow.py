"""Floating-point numbers that carry the number which exact arithmetic would have given, as a ball of 300 bits.

Code that is written for floats runs on them unchanged: comparisons and branches are those of the floats. Functions
that a float evaluates by a polynomial are replaced, see :func:`shadowed`: the float is theirs, the ball the true value.
"""

from contextlib import contextmanager

from flint import arb, arb_mat, ctx

from grazing.kernel import elementary
from grazing.oscillator import cells, constants, flight, windows

plain_angle = constants.angle

BITS = 300


class Shadow(float):
    """A float and the ball of what it stands for."""

    def __new__(cls, value, exact=None):
        made = super().__new__(cls, value)
        made.exact = exact if exact is not None else getattr(value, "exact", None) or arb(float(value))
        return made

    def __neg__(self):
        return Shadow(-float(self), -self.exact)

    def __abs__(self):
        return -self if float(self) < 0.0 else self


def exact(x):
    """The ball of a number; that of a plain float is the float."""
    return x.exact if isinstance(x, Shadow) else arb(x)


def _operation(name):
    plain = getattr(float, f"__{name}__")

    def forward(self, other):
        return Shadow(plain(float(self), float(other)), getattr(arb, f"__{name}__")(self.exact, exact(other)))

    def backward(self, other):
        return Shadow(plain(float(other), float(self)), getattr(arb, f"__{name}__")(exact(other), self.exact))

    return forward, backward


for _name in ("add", "sub", "mul", "truediv"):
    _forward, _backward = _operation(_name)
    setattr(Shadow, f"__{_name}__", _forward)
    setattr(Shadow, f"__r{_name}__", _backward)


def sqrt(x):
    return Shadow(float(x) ** 0.5, exact(x).sqrt())


def exp(x):
    return Shadow(elementary.exp(float(x)), exact(x).exp())


def sincos(x):
    s, c = elementary.sincos(float(x))
    S, C = exact(x).sin_cos()
    return Shadow(s, S), Shadow(c, C)


def floats(c):
    """The same numbers without their balls."""
    if isinstance(c, tuple):
        made = [floats(x) for x in c]
        return type(c)(*made) if hasattr(c, "_fields") else tuple(made)
    return float(c) if isinstance(c, Shadow) else c


def propagated(s, phase, c):
    """The matrix of the flight over a time s: state (y, v, 1, cos 1, sin 1, cos 2, ...), phases from ``phase`` on."""
    m, omega = len(c.cos), exact(c.omega)
    A = [[arb(0)] * (3 + 2 * m) for _ in range(3 + 2 * m)]
    A[0][1], A[1][0], A[1][1], A[1][2] = arb(1), -exact(c.k2), -exact(c.alpha), exact(c.F0)
    for j in range(m):
        i, W = 3 + 2 * j, (j + 1) * omega
        A[1][i], A[1][i + 1] = exact(c.cos[j]), exact(c.sin[j])
        A[i][i + 1], A[i + 1][i] = -W, W
    E = arb_mat([[x * exact(s) for x in row] for row in A]).exp()
    start = [arb(0), arb(0), arb(1)]
    for j in range(m):
        sine, cosine = ((j + 1) * phase).sin_cos()
        start += [cosine, sine]
    return E, start


def modes(s, c):
    E, _start = propagated(s, arb(0), c)
    found = flight.modes(float(s), floats(c))
    return tuple(Shadow(x, E[i, j]) for x, (i, j) in zip(found, ((0, 0), (0, 1), (1, 0), (1, 1)), strict=True))


def duhamel(s, t, c):
    E, start = propagated(s, exact(c.omega) * exact(t) + exact(c.theta), c)
    y, v = flight.duhamel(float(s), float(t), floats(c))
    return tuple(
        Shadow(x, sum((E[i, j] * start[j] for j in range(2, len(start))), arb(0))) for i, x in enumerate((y, v))
    )


def angle(omega, t):
    return Shadow(plain_angle(float(omega), float(t)), exact(omega) * exact(t))


def window_edges(*arguments):
    """The edges as they are: that they are near enough to the zeros of the force is another question."""
    edges, *rest = windows.window_edges(*floats(arguments))
    return tuple(Shadow(x) for x in edges), *rest


@contextmanager
def shadowed(monkeypatch):
    """Let constants and tables be made of shadows, their exact parts being what exact arithmetic would have given."""
    with monkeypatch.context() as patch, ctx.workprec(BITS):
        for module in (cells, constants):
            patch.setattr(module, "sqrt", sqrt)
        for name, function in (("exp", exp), ("sincos", sincos), ("duhamel", duhamel), ("modes", modes)):
            patch.setattr(cells, name, function)
        for name, function in (("angle", angle), ("window_edges", window_edges)):
            patch.setattr(constants, name, function)
        patch.setattr(constants, "pi", Shadow(constants.pi, arb.pi()))
        yield patch
