"""PPO follows the runs that OpenAI published. 250,000 steps take 11 minutes on two cores."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("torch")

from learners import ppo, published

# Beside the checkout; the published runs saw the same art.
_ART = Path(__file__).resolve().parents[5] / "shared" / "released-art"
_STEPS = 250_000


@pytest.mark.skipif(not _ART.exists(), reason="upstream's art is not beside the checkout")
def test_fruitbot_is_within_two_deviations_of_the_published_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROCGEN_ART", str(_ART))
    words = ["--game", "fruitbot", "--total-steps", str(_STEPS), "--output", str(tmp_path)]
    assert ppo.main(words) == 0
    compared = published.distances([tmp_path])[_STEPS]
    for name in ("return", "explained_variance"):
        mean, distance = compared[name]
        assert abs(distance) <= 2, f"{name} is {mean:.4g}, {distance:+.1f} deviations from OpenAI's"
