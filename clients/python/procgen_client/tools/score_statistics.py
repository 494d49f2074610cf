"""Statistics of scores: standard errors, interquartile means, bootstrap confidence intervals.

Definitions as in rliable (Agarwal et al., 2021), "Deep reinforcement learning at the edge of the
statistical precipice".
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

CONFIDENCE = 0.95
_RESAMPLE_COUNT = 2000


def standard_error(values: npt.ArrayLike) -> float:
    """Returns the standard error of the mean; NaN for fewer than two values."""
    array = np.asarray(values, np.float64)
    if array.size < 2:
        return float("nan")
    return float(array.std(ddof=1) / np.sqrt(array.size))


def interquartile_mean(scores: npt.ArrayLike) -> np.ndarray:
    """Returns the mean of the middle half of the scores, along the last axis.

    Of n scores the lowest and the highest n // 4 are left out, so of fewer than four none.
    """
    ordered = np.sort(np.asarray(scores, np.float64), axis=-1)
    cut = ordered.shape[-1] // 4
    middle: np.ndarray = ordered[..., cut : ordered.shape[-1] - cut].mean(-1)
    return middle


def resampled_means(strata: Sequence[np.ndarray], seed: int) -> np.ndarray:
    """Returns means of stratified bootstrap samples, float64 [samples, strata].

    Args:
        strata: Values of each stratum, e.g. of the episodes of each game.
        seed: Seeds the samples. Equal arguments give equal results.
    """
    random = np.random.default_rng(seed)
    means = [
        values[random.integers(0, len(values), (_RESAMPLE_COUNT, len(values)))].mean(1)
        for values in strata
    ]
    return np.stack(means, -1)


def confidence_interval(resampled: np.ndarray) -> tuple[float, float]:
    """Returns the percentile interval of a statistic of the samples, with CONFIDENCE."""
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(resampled, [tail, 1 - tail])
    return float(low), float(high)
