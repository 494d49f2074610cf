"""Statistics of scores follow their definitions in rliable (Agarwal et al., 2021)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from procgen_client.tools.score_statistics import (
    confidence_interval,
    interquartile_mean,
    resampled_means,
    standard_error,
)


def test_standard_error_is_that_of_the_mean() -> None:
    assert standard_error([1, 2, 3, 4]) == pytest.approx(math.sqrt(5 / 3) / 2)
    assert math.isnan(standard_error([1]))


def test_interquartile_mean_leaves_out_a_quarter_on_either_side() -> None:
    # scipy.stats.trim_mean(scores, 0.25), which rliable uses: n // 4 of n on either side.
    assert interquartile_mean([100, 1, 2, 3, -50, 4, 5, 6]) == 3.5
    assert interquartile_mean([9, 1, 2, 3, 4]) == 3
    assert interquartile_mean([9, 1, 2]) == 4
    assert interquartile_mean([[9, 1, 2, 3], [0, 0, 4, 8]]).tolist() == [2.5, 2]


def test_bootstrap_resamples_each_stratum_by_itself() -> None:
    strata = [np.array([1.0]), np.array([0.0, 10.0]), np.arange(100.0)]
    means = resampled_means(strata, seed=3)
    assert means.shape[1] == 3
    assert set(means[:, 0]) == {1}
    assert set(means[:, 1]) == {0, 5, 10}
    assert means[:, 2].mean() == pytest.approx(49.5, abs=0.5)
    assert means[:, 2].std() == pytest.approx(np.arange(100).std() / 10, rel=0.1)
    np.testing.assert_array_equal(resampled_means(strata, seed=3), means)
    assert (resampled_means(strata, seed=4) != means).any()


def test_interval_covers_the_mean_as_often_as_its_confidence() -> None:
    random = np.random.default_rng(0)
    covered = 0
    for seed in range(200):
        sample = random.exponential(size=200)  # Of mean 1.
        low, high = confidence_interval(resampled_means([sample], seed)[:, 0])
        assert low < sample.mean() < high
        covered += low <= 1 <= high
    assert 0.91 <= covered / 200 <= 0.98
