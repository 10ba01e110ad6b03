"""Small systems of linear equations in plain scalar code, so that kernels can take Newton steps."""

from __future__ import annotations

from typing import Any


def solved(a: Any, b: Any, unit: Any) -> bool:
    """Solve a x = b by elimination with pivots; x replaces b, and a is destroyed. False for a singular matrix.

    Each equation is divided by the greatest of its terms for unknowns of the size of their units, so that the pivots
    are the same in all units.

    Parameters
    ----------
    a : ndarray, shape (d, d)
    b : ndarray, shape (d,)
    unit : ndarray, shape (m,)
        Of the unknowns; they repeat themselves after m of them.
    """
    d, m = a.shape[0], unit.shape[0]
    for i in range(d):
        size = 0.0
        for j in range(d):
            size = max(size, abs(a[i, j]) * unit[j % m])
        if not size > 0.0:
            return False
        for j in range(d):
            a[i, j] /= size
        b[i] /= size
    for k in range(d):
        pivot = k
        for i in range(k + 1, d):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if not abs(a[pivot, k]) > 0.0:
            return False
        for j in range(d):
            a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
        b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, d):
            factor = a[i, k] / a[k, k]
            for j in range(k, d):
                a[i, j] -= factor * a[k, j]
            b[i] -= factor * b[k]
    for k in range(d - 1, -1, -1):
        for j in range(k + 1, d):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    return True
