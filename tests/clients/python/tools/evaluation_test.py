"""The evaluation follows the paper's protocol, with the constants of the catalog."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from procgen_client import Client, Episode, errors
from procgen_client.options import GAMES
from procgen_client.tools import evaluation, score_report
from procgen_client.tools.evaluation import Evaluation, Protocol
from procgen_client.tools.play_episodes import Policy
from procgen_client.tools.score_statistics import interquartile_mean

_SMALL = Protocol(mode="easy", train_levels=3, episode_count=12, env_count=4, rand_seed=5)


def always(action: int) -> evaluation.MakePolicy:
    return lambda game: lambda observations: np.full(len(observations), action)


def test_scores_are_means_normalised_by_the_catalog() -> None:
    result = evaluation.evaluate(["bigfish"], evaluation.random_policy, _SMALL)
    (score,) = result.games
    for levels in (score.train, score.test):
        returns = [episode.episode_return for episode in levels.episodes]
        assert len(returns) == 12
        assert levels.return_mean == pytest.approx(np.mean(returns))
        deviation = np.std(returns, ddof=1)
        assert levels.return_standard_error == pytest.approx(deviation / math.sqrt(12))
        # Cobbe et al., 2020, appendix C: bigfish's constants in easy mode are 1 and 40.
        assert levels.score == pytest.approx((levels.return_mean - 1) / 39)
        low, high = levels.score_interval
        assert low < levels.score < high
        width = 2 * 1.96 * levels.return_standard_error / 39
        assert high - low == pytest.approx(width, rel=0.3)
    assert score.return_range == (1, 40)
    assert {episode.level_seed for episode in score.train.episodes} <= {0, 1, 2}
    assert not {episode.level_seed for episode in score.test.episodes} <= {0, 1, 2}


def test_overall_scores_are_those_of_the_games() -> None:
    games = ["dodgeball", "bigfish", "plunder", "starpilot", "leaper"]
    result = evaluation.evaluate(games, evaluation.random_policy, _SMALL)
    scores = [score.test.score for score in result.games]
    assert [score.game for score in result.games] == games
    assert result.test.mean == pytest.approx(np.mean(scores))
    assert result.test.interquartile_mean == pytest.approx(interquartile_mean(scores))
    for value, (low, high) in (result.test[:2], result.test[2:]):
        assert low <= value <= high
        assert low < high


def test_equal_seeds_give_equal_evaluations() -> None:
    one, other = (
        evaluation.evaluate(["bigfish"], evaluation.random_policy, _SMALL)
        for _ in range(2)
    )
    assert one == other
    another = evaluation.evaluate(
        ["bigfish"], evaluation.random_policy, _SMALL._replace(rand_seed=6)
    )
    assert another.test != one.test


def test_default_train_levels_are_those_of_the_paper_and_reported(client: Client) -> None:
    assert evaluation.TRAIN_LEVELS == {"easy": 200, "hard": 500}
    made: list[int] = []

    def make(game: str) -> Policy:
        # Records num_levels of the pool on the server while the game is played.
        def act(observations: np.ndarray) -> np.ndarray:
            made.extend(pool.spec.options.num_levels for pool in client.list_pools())
            return np.full(len(observations), -1)

        return act

    for mode, count in evaluation.TRAIN_LEVELS.items():
        result = evaluation.evaluate(
            ["maze"], make, Protocol(mode, episode_count=1), server=client
        )
        assert result.protocol.train_levels == count
        assert score_report.table(result).startswith(
            f"{mode} mode; training levels are 0 ... {count - 1}\n"
        )
    assert made == [200, 0, 500, 0]


def test_policy_gets_the_observations_that_it_needs() -> None:
    shapes = set()

    def make(game: str) -> Policy:
        def act(observations: np.ndarray) -> np.ndarray:
            shapes.add(observations.shape)
            return np.full(len(observations), -1)

        return act

    options = {"frame_stack": 4, "grayscale_obs": True, "layout": "chw", "screen_size": 32}
    evaluation.evaluate(["maze"], make, _SMALL._replace(options=options))
    assert shapes == {(4, 4, 1, 32, 32)}
    with pytest.raises(errors.InvalidArgumentError, match="'num_levels'; it is one of screen_size"):
        evaluation.evaluate(["maze"], make, _SMALL._replace(options={"num_levels": 1}))


def test_every_game_has_normalization_constants_in_both_modes() -> None:
    for mode in evaluation.TRAIN_LEVELS:
        for game in GAMES:
            low, high = evaluation.return_range(game, mode)
            assert low < high


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mode": "memory"}, "mode is 'memory'; it is one of easy, hard"),
        ({"episode_count": 0}, "episode_count is 0"),
        ({"env_count": 0}, "env_count is 0"),
        ({"train_levels": -1}, "train_levels is -1"),
    ],
)
def test_invalid_protocols_are_rejected(
    change: dict[str, object], message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        evaluation.evaluate(["maze"], always(4), _SMALL._replace(**change))


def _evaluation(*scores: tuple[float, float], episodes: int) -> Evaluation:
    games = []
    for game, (train, test) in zip(("coinrun", "maze"), scores, strict=False):
        each = [
            evaluation.LevelSetScore(
                [Episode(0, 7, 10.0, 20, True)] * episodes,
                *(5 + 5 * score, float("nan") if episodes == 1 else 0.25, score),
                (score - 0.1, score + 0.1),
            )
            for score in (train, test)
        ]
        games.append(evaluation.GameScore(game, (5, 10), *each))
    overall = [
        evaluation.Aggregate(np.mean(each), (0.1, 0.9), np.median(each), (0.2, 0.8))
        for each in zip(*scores, strict=True)
    ]
    return Evaluation(Protocol("easy", 200), games, *overall)


def test_table_ends_with_the_scores_over_all_games() -> None:
    result = _evaluation((0.8, 0.6), (0.4, 0.0), episodes=10)
    assert score_report.table(result).splitlines()[4:] == [
        "| coinrun | 10 | 9.00 ± 0.25 | 8.00 ± 0.25 "
        "| 0.800 [0.700, 0.900] | 0.600 [0.500, 0.700] | 0.200 |",
        "| maze | 10 | 7.00 ± 0.25 | 5.00 ± 0.25 "
        "| 0.400 [0.300, 0.500] | 0.000 [-0.100, 0.100] | 0.400 |",
        "| mean | | | | 0.600 [0.100, 0.900] | 0.300 [0.100, 0.900] | 0.300 |",
        "| interquartile mean | | | | 0.600 [0.200, 0.800] | 0.300 [0.200, 0.800] | 0.300 |",
    ]


def test_a_single_episode_has_no_standard_error() -> None:
    result = _evaluation((0.8, 0.6), episodes=1)
    assert "| coinrun | 1 | 9.00 | 8.00 |" in score_report.table(result)
    written = json.loads(json.dumps(score_report.results(result, "mine"), allow_nan=False))
    assert written["games"][0]["train"]["return_standard_error"] is None
    assert written["episodes"] == [
        {
            "game": "coinrun",
            "mode": "easy",
            "levels": levels,
            "level_seed": 7,
            "return": 10.0,
            "length": 20,
            "level_complete": True,
        }
        for levels in ("train", "test")
    ]
