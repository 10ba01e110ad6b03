"""The 0-1 test for chaos, from a series alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.random import uniform
from grazing.memory import refuse_too_large
from grazing.outcome import InputError
from grazing.parameter import in_order, whole
from grazing.studies.starts import checked_seed

#: Shortest series: a tenth of it must hold a few displacements.
SHORTEST = 100


def zero_one(series: ArrayLike, *, frequencies: int = 100, seed: int = 0) -> NDArray[np.float64] | float:
    """Return K of the 0-1 test: near 0 for regular and near 1 for chaotic motion.

    Parameters
    ----------
    series : array_like, shape (n,) or (n, m)
        One observable along an orbit, such as a coordinate, or those of m orbits; at least 100 values. A series
        sampled much faster than it varies looks regular: take points of a map.
    frequencies : int
        How many random frequencies in (pi/5, 4 pi/5) the median is taken over.
    seed : int

    Returns
    -------
    float or ndarray, shape (m,)
        The median over the frequencies of the correlation between the mean square displacement and time. The mean of
        the series is subtracted first, as what it adds oscillates: so the origin of an observable does not matter. Not
        a number for a series that is not finite; 0 for one that does not vary.

    References
    ----------
    Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145.

    Examples
    --------
    >>> import numpy as np, grazing as gz
    >>> from grazing.studies.zero_one import zero_one
    >>> logistic = gz.Map(lambda x, p: (p.a * x[0] * (1.0 - x[0]),), params={"a": 4.0})
    >>> chaotic = logistic.iterate((0.3,), 3000)[1000:, 0]
    >>> regular = gz.gap_map(lam=0.5, mu=0.07, l=0.1).iterate((0.1,), 3000)[1000:, 0]
    >>> bool(zero_one(chaotic) > 0.9), bool(abs(zero_one(regular)) < 0.1)
    (True, True)
    """
    try:
        if np.iscomplexobj(series):
            raise TypeError
        values = np.array(in_order(series), np.float64)
    except Exception:  # of whatever object was given, or of one too large
        raise InputError("the series is not numbers; give an array of shape (n,) or (n, m)") from None
    if values.ndim not in (1, 2) or len(values) < SHORTEST:
        raise InputError(f"the series has shape {values.shape}; give (n,) or (n, m) with n >= {SHORTEST}")
    count = whole(frequencies, "frequencies", 1)
    # random numbers and the hashes they come from; walks, and their Fourier transforms over up to four times as much
    size = 64.0 * count + 256.0 * len(values)
    refuse_too_large(size, f"reduce frequencies ({count}) or the series ({len(values)})", "the test")
    c = np.pi * (0.2 + 0.6 * uniform(checked_seed(seed), (), count, 1)[:, 0])
    found = np.array([_median(column, c) for column in values.reshape(len(values), -1).T])
    return found if values.ndim == 2 else float(found[0])


def _median(x: NDArray[np.float64], c: NDArray[np.float64]) -> float:
    if not np.isfinite(x).all():
        return float("nan")
    size = np.abs(x).max()
    if size > 0.0:
        x = x / size
    if np.ptp(x) <= 1e-12:
        return 0.0
    n = len(x)
    lags = np.arange(1, n // 10 + 1)
    x = x - x.mean()
    correlations = []
    for frequency in c:
        walk = np.cumsum(x * np.exp(1j * frequency * np.arange(1, n + 1)))
        correlations.append(np.corrcoef(lags, _displacements(walk, lags))[0, 1])
    return float(np.median(correlations))


def _displacements(walk: NDArray[np.complex128], lags: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the mean of |walk[j + lag] - walk[j]|^2 for each lag, over the j that all lags have.

    The squares come from running sums, the products of all lags at once from Fourier's transform.
    """
    kept = len(walk) - int(lags[-1])
    room = 1 << (len(walk) + kept).bit_length()
    spectrum = np.fft.fft(walk, room) * np.conj(np.fft.fft(walk[:kept], room))
    sums = np.concatenate([[0.0], np.cumsum(np.abs(walk) ** 2)])
    together = np.fft.ifft(spectrum)[lags].real
    return np.asarray((sums[lags + kept] - sums[lags] + sums[kept] - 2.0 * together) / kept)
