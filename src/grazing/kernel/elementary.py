"""Own exponential, sine, cosine, logarithm, angles, remainder: the same bits everywhere, the first three branchless.

The C library's versions differ between systems in the last digit and stop a loop from vectorising. Errors against
400-bit arithmetic, measured in ``tests/kernel/test_elementary.py``: ``exp`` below 1.3 units in the last place on
[-708, 709], ``sincos`` below 1.5e-16 on |x| < 1e5, ``log`` below 1 unit in the last place.
"""

from __future__ import annotations

from math import copysign, sqrt

from grazing.kernel.primitives import exponent_of, power_of_two

INFINITY, NAN = float("inf"), float("nan")
_PI, _HALF_PI_OF = 3.141592653589793, 1.5707963267948966
# Adding and subtracting 1.5 * 2**52 rounds to the nearest integer.
_ROUND = 6755399441055744.0
_LOG2_E = 1.4426950408889634
# ln 2 and pi/2 in pieces whose product with a small integer is exact (Cody and Waite 1980; pieces as in fdlibm).
_LN2_HIGH = 6.93147180369123816490e-01
_LN2_LOW = 1.90821492927058770002e-10
_TWO_OVER_PI = 6.36619772367581382433e-01
_HALF_PI_1 = 1.57079632673412561417e00
_HALF_PI_2 = 6.07710050630396597660e-11
_HALF_PI_3 = 2.02226624879595063154e-21


def exp(x: float) -> float:
    """Return e**x; 0 below -708 and infinity above 709."""
    inside = min(max(x, -708.0), 709.0)
    n = (inside * _LOG2_E + _ROUND) - _ROUND
    r = (inside - n * _LN2_HIGH) - n * _LN2_LOW
    # Taylor polynomial of degree 13 on |r| <= ln(2)/2: remainder 4e-18.
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    value = (1.0 + (r + r * r * p)) * power_of_two(n)
    value = 0.0 if x < -708.0 else value
    return float("inf") if x > 709.0 else value


def sincos(x: float) -> tuple[float, float]:
    """Return (sin x, cos x) for |x| < 1e5."""
    n = (x * _TWO_OVER_PI + _ROUND) - _ROUND
    r = ((x - n * _HALF_PI_1) - n * _HALF_PI_2) - n * _HALF_PI_3
    z = r * r
    # Minimax polynomials of fdlibm on |r| <= pi/4.
    s = 1.58969099521155010221e-10
    s = s * z - 2.50507602534068634195e-08
    s = s * z + 2.75573137070700676789e-06
    s = s * z - 1.98412698298579493134e-04
    s = s * z + 8.33333333332248946124e-03
    s = s * z - 1.66666666666666324348e-01
    sine = r + r * (z * s)
    c = -1.13596475577881948265e-11
    c = c * z + 2.08757232129817482790e-09
    c = c * z - 2.75573143513906633035e-07
    c = c * z + 2.48015872894767294178e-05
    c = c * z - 1.38888888888741095749e-03
    c = c * z + 4.16666666666666019037e-02
    half = 0.5 * z
    w = 1.0 - half
    cosine = w + (((1.0 - w) - half) + z * (z * c))
    quarter = n - 4.0 * ((n * 0.25 - 0.375 + _ROUND) - _ROUND)  # n modulo 4: 0, 1, 2 or 3
    odd = (quarter - 2.0) * (quarter - 2.0) == 1.0
    first = cosine if odd else sine
    second = sine if odd else cosine
    first = first if quarter < 2.0 else -first
    second = -second if (quarter - 1.5) * (quarter - 1.5) < 1.0 else second
    return first, second


def length(x: float, y: float) -> float:
    """Return sqrt(x^2 + y^2), also where squares are below all doubles or beyond them."""
    square = x * x + y * y
    if 1e-280 < square < 1e300:
        return sqrt(square)
    size = max(abs(x), abs(y))
    if not 0.0 < size < float("inf"):
        return abs(x) + abs(y)  # which is no number beside one that is none
    x, y = x / size, y / size
    return size * sqrt(x * x + y * y)


def log(x: float) -> float:
    """Return the natural logarithm of x; minus infinity for 0, not a number below."""
    if not 0.0 < x < float("inf"):
        return x if x > 0.0 else (-float("inf") if x == 0.0 else float("nan"))
    shift = 0.0
    if x < 2.2250738585072014e-308:  # 2^-1022: below, numbers have fewer digits and no exponent of their own
        x, shift = x * 18014398509481984.0, 54.0
    n = exponent_of(x)
    half = 512.0 if n > 512.0 else (-512.0 if n < -512.0 else 0.0)
    m = x * power_of_two(-half) * power_of_two(half - n)
    if m > 1.4142135623730951:
        m, n = 0.5 * m, n + 1.0
    n -= shift
    # log(1 + f) = 2 artanh(s), s = f/(2 + f); minimax polynomials of fdlibm on sqrt(1/2) < m < sqrt(2).
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01))
    even = z * (
        6.666666666666735130e-01
        + w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    square = 0.5 * f * f
    return n * _LN2_HIGH - ((square - (s * (square + (odd + even)) + n * _LN2_LOW)) - f)


def power(x: float, y: float) -> float:
    """Return x**y for x >= 0: by multiplication for whole y below 2^31, else as exp(y log x)."""
    count = abs(y)
    if count < 2147483648.0 and (count + _ROUND) - _ROUND == count:
        left, square, product = int(count), x, 1.0
        while left > 0:
            if left % 2 == 1:
                product *= square
            square *= square
            left //= 2
        return 1.0 / product if y < 0.0 else product
    return exp(y * log(x))


def remainder(x: float, y: float) -> float:
    """Return what is left of x after whole multiples of y, exactly and with the sign of x, as C's fmod does."""
    left, unit = abs(x), abs(y)
    if not (left < INFINITY and unit > 0.0):
        return NAN
    while left >= unit:
        part = unit
        while part <= 0.5 * left:
            part += part
        left -= part  # exact: it is at least half of it
    return -left if x < 0.0 else left


def arctan(x: float) -> float:
    """Return the arctangent, by minimax polynomials of fdlibm about 0, 1/2, 1, 3/2 and infinity."""
    a = abs(x)
    if a < 0.4375:
        r, high, low = a, 0.0, 0.0
    elif a < 0.6875:
        r, high, low = (2.0 * a - 1.0) / (2.0 + a), 4.63647609000806093515e-01, 2.26987774529616870924e-17
    elif a < 1.1875:
        r, high, low = (a - 1.0) / (a + 1.0), 7.85398163397448278999e-01, 3.06161699786838301793e-17
    elif a < 2.4375:
        r, high, low = (a - 1.5) / (1.0 + 1.5 * a), 9.82793723247329054082e-01, 1.39033110312309984516e-17
    else:
        r, high, low = -1.0 / a, 1.57079632679489655800e00, 6.12323399573676603587e-17
    z = r * r
    w = z * z
    odd = z * (
        3.33333333333329318027e-01
        + w * (1.42857142725034663711e-01
        + w * (9.09088713343650656196e-02
        + w * (6.66107313738753120669e-02
        + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02))))
    )  # fmt: skip
    even = w * (
        -1.99999999998764832476e-01
        + w * (-1.11111104054623557880e-01
        + w * (-7.69187620504482999495e-02
        + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02)))
    )  # fmt: skip
    return copysign(high - ((r * (odd + even) - low) - r), x)


def arctan2(y: float, x: float) -> float:
    """Return the polar angle of (x, y), from -pi to pi, 0 for no direction."""
    if x == 0.0 and y == 0.0:
        return 0.0
    if abs(y) <= abs(x):
        turn = arctan(y / x)
        return turn if x > 0.0 else turn + copysign(_PI, y)
    return copysign(_HALF_PI_OF, y) - arctan(x / y)


def arccos(x: float) -> float:
    """Return the angle from 0 to pi whose cosine is x, for -1 <= x <= 1."""
    return 2.0 * arctan2(sqrt(1.0 - x), sqrt(1.0 + x))
