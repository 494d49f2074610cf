"""Play, replays and the gallery, over the web protocol."""

from __future__ import annotations

import asyncio
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from page import Answer, Page, PageError, WebServer, conformance, open_page

from procgen_client import Client

_GOLDEN = Path(__file__).resolve().parents[2] / "conformance" / "golden"
# Actions that change every game.
_ACTIONS = [7, 7, 8, 5, 2, 7, 1, 4, 6, 9, 0, 3] * 10


def run(test: Any) -> None:
    asyncio.run(test)


async def play(page: Page, actions: list[int], **members: Any) -> tuple[int, list[Answer]]:
    views = [await page.call("play.start", **members)]
    number = views[0].result["play"]
    for action in actions:
        views.append(await page.call("play.step", play=number, action=action))
    return number, views


def without_pictures(answer: Answer) -> dict[str, Any]:
    return {key: value for key, value in answer.result.items() if key not in ("play", "replay")}


def test_a_play_is_a_pool_of_the_viewer_and_shows_both_views(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client:
            async with open_page(server.url) as page:
                number, views = await play(
                    page, [7, 7], game="coinrun", mode="easy", level_seed=1000, human_size_px=128
                )
                (pool,) = client.list_pools()
                assert pool.name.startswith("pools/web-play-") and pool.spec.env_count == 1
                first, _, last = views
                assert first.result["step"] == 0 and first.result["first"] is True
                assert first.result["level_seed"] == 1000 and last.result["step"] == 2
                assert last.result["first"] is False and last.result["fingerprint"] is None
                assert last.result["episode_step"] == 2 and last.result["episode_count"] == 0
                agent, human = last.entries
                assert (agent["name"], agent["format"], agent["width"]) == ("agent", "rgb", 64)
                assert (human["name"], human["format"], human["width"]) == ("human", "png", 128)
                assert len(last.parts["agent"]) == 64 * 64 * 3
                assert last.parts["human"].startswith(b"\x89PNG\r\n\x1a\n")
                assert first.parts["agent"] != last.parts["agent"]
                for members in ({"human_size_px": 64}, {}):
                    smaller = await page.call("play.step", play=number, action=7, **members)
                    assert smaller.entries[1]["width"] == 64
                with pytest.raises(PageError, match="human_size_px is 63"):
                    await page.call("play.step", play=number, action=7, human_size_px=63)
                await page.call("play.close", play=number)
                assert client.list_pools() == []
                await play(page, [], game="maze", mode="easy", level_seed=1)
                assert len(client.list_pools()) == 1
            # The page is closed.
            while client.list_pools():
                await asyncio.sleep(0.01)

    run(test())


@pytest.mark.parametrize(
    ("game", "mode", "options"),
    [
        ("coinrun", "easy", {}),
        ("maze", "hard", {"use_sequential_levels": True}),
        ("bigfish", "easy", {"use_monochrome_assets": True, "use_backgrounds": False}),
        ("climber", "hard", {"paint_vel_info": True, "center_agent": False}),
        ("miner", "memory", {"restrict_themes": True}),
        ("starpilot", "extreme", {"use_generated_assets": True}),
        ("heist", "exploration", {}),
        ("coinrun", "hard", {"debug_mode": 14}),
    ],
)
def test_conformance_replays_a_play_bit_for_bit(
    server: WebServer, tmp_path: Path, game: str, mode: str, options: dict[str, Any]
) -> None:
    async def test() -> None:
        chosen = {} if mode == "exploration" else {"level_seed": 1000}
        async with open_page(server.url) as page:
            number, views = await play(
                page, _ACTIONS, game=game, mode=mode, options=options, human_size_px=0, **chosen
            )
            saved = await page.call("play.trace", play=number)
        assert saved.result["steps"] == len(_ACTIONS)
        assert saved.result["file_name"].startswith(f"{game}.{mode}.")
        trace = saved.parts["trace"]
        assert conformance(trace, tmp_path).endswith("1 passed, 0 failed, 0 skipped\n")
        # procgen-conformance detects a different action and a different reward.
        rewards_at = trace.index(b"\n") + 1 + len(_ACTIONS)
        broken = trace[:rewards_at] + b"\x01" + trace[rewards_at + 1 :]
        assert conformance(broken, tmp_path).endswith("0 passed, 1 failed, 0 skipped\n")
        assert views[-1].result["step"] == len(_ACTIONS)

    run(test())


def golden(name: str) -> tuple[bytes, dict[str, Any], list[int]]:
    """Returns a recording of Procgen 0.10.7: its path, header and actions."""
    contents = (_GOLDEN / f"{name}.trace").read_bytes()
    at = contents.index(b"\n") + 1
    header = json.loads(contents[:at])
    return contents, header, list(contents[at : at + header["steps"] * header["num_envs"]])


def test_a_solved_level_is_reported(server: WebServer, tmp_path: Path) -> None:
    contents, header, actions = golden("coinrun.easy.solved-1001")

    async def test() -> None:
        async with open_page(server.url) as page:
            number, views = await play(
                page, actions, game="coinrun", mode="easy", level_seed=1001, human_size_px=0
            )
            end = next(view.result for view in views if view.result["prev_level_complete"])
            assert end["total_reward"] == 10 and end["reward"] == 10 and end["first"] is True
            assert end["episode_count"] == 1 and len(end["fingerprint"]) == 16
            # The same level is played again.
            assert end["level_seed"] == end["prev_level_seed"] == 1001
            saved = (await page.call("play.trace", play=number)).parts["trace"]
            saved_header = json.loads(saved[: saved.index(b"\n")])
            assert saved_header["fingerprints"][0][0] == end["fingerprint"]
            # Apart from the fingerprints, the header equals the recording's.
            assert saved[saved.index(b"\n") :] == contents[contents.index(b"\n") :]
            assert {**saved_header, "fingerprints": 0} == {**header, "fingerprints": 0}

    run(test())


@pytest.mark.parametrize(
    ("name", "level_seed"), [("coinrun.easy.solved-1001", 1001), ("miner.hard.solved-1002", 1002)]
)
def test_the_end_of_an_episode_shows_its_last_frames(
    server: WebServer, name: str, level_seed: int
) -> None:
    _, header, actions = golden(name)
    actions = [action for action in actions[:: header["num_envs"]] if action != 255]

    async def test() -> None:
        game, mode = name.split(".")[:2]
        chosen = {"game": game, "mode": mode, "level_seed": level_seed, "human_size_px": 96}
        async with open_page(server.url) as page:
            number, views = await play(page, actions, **chosen)
            row = next(i for i, view in enumerate(views) if i > 0 and view.result["first"])
            end = views[row]
            assert list(end.parts) == ["agent", "final_agent", "final_human", "human"]
            # The next episode begins with the same level.
            assert (end.parts["agent"], end.parts["human"]) == tuple(views[0].parts.values())
            assert all("final_agent" not in view.parts for view in views[:row])
            with Client(server.process.address) as client:
                options = {"start_level": level_seed, "num_levels": 1, "rand_seed": 0}
                pool = client.create_pool(
                    game, 1, autoreset_mode="next_step", distribution_mode=mode, **options
                )
                with pool:
                    for action in actions[:row]:
                        batch = pool.step([action])
                    assert end.parts["final_agent"] == batch.observations.tobytes()
                    (human,) = pool.render(size_px=96)
                shown = Image.open(io.BytesIO(end.parts["final_human"]))
                assert np.array_equal(np.asarray(shown), human)
            replay = (await page.call("replay.open", play=number, human_size_px=96)).result
            for wanted in (row, row - 1, row, row, 0, row):
                view = await page.call("replay.seek", replay=replay["replay"], row=wanted)
                assert view.parts == views[wanted].parts, wanted

    run(test())


def test_a_step_for_an_episode_that_has_ended_is_rejected(server: WebServer) -> None:
    _, _, actions = golden("coinrun.easy.solved-1001")

    async def test() -> None:
        async with open_page(server.url) as page:
            level = {"game": "coinrun", "mode": "easy", "level_seed": 1001, "human_size_px": 0}
            number = (await page.call("play.start", **level)).result["play"]
            # As a page on a long line does: all are sent before the first response.
            sent = [
                page.send("play.step", play=number, action=action, episode_count=0)
                for action in actions
            ]
            views = await asyncio.gather(*sent, return_exceptions=True)
            taken = [view for view in views if not isinstance(view, PageError)]
            late = [view for view in views if isinstance(view, PageError)]
            assert taken and late and views == taken + late
            assert [view.result["first"] for view in taken] == [False] * (len(taken) - 1) + [True]
            reason = "episode_count is 0, the play has finished 1 episodes; nothing was stepped"
            assert {(error.code, error.message) for error in late} == {
                ("FAILED_PRECONDITION", reason)
            }
            trace = await page.call("play.trace", play=number)
            assert trace.result["steps"] == len(taken)

    run(test())


def test_episodes_that_end_earlier_than_recorded_are_replayed(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            number, views = await play(
                page, _ACTIONS, game="bigfish", mode="easy", level_seed=7, human_size_px=0
            )
            ends = [i for i, view in enumerate(views) if i > 0 and view.result["first"]]
            assert ends
            trace = (await page.call("play.trace", play=number)).parts["trace"]
            rows = len(_ACTIONS) + 1
            first_at = trace.index(b"\n") + 1 + len(_ACTIONS) + 4 * rows
            assert [i for i in range(rows) if trace[first_at + i]] == [0, *ends]
            changed = trace[: first_at + 1] + bytes(rows - 1) + trace[first_at + rows :]
            opened = (await page.call("replay.open", changed, human_size_px=0)).result
            difference = {"row": ends[0], "field": "first", "expected": 0, "got": 1}
            assert opened["difference"] == difference
            assert opened["rewards"] == [view.result["reward"] for view in views]

    run(test())


def test_restart_repeats_the_level_and_clears_the_recording(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            number, views = await play(
                page, _ACTIONS[:20], game="starpilot", mode="easy", level_seed=5, human_size_px=64
            )
            again = await page.call("play.restart", play=number)
            assert again == views[0]
            for action, view in zip(_ACTIONS, views[1:]):
                assert await page.call("play.step", play=number, action=action) == view
            assert (await page.call("play.trace", play=number)).result["steps"] == 20

    run(test())


def test_the_next_level_has_the_next_seed(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            number, _ = await play(page, [7], game="maze", mode="easy", level_seed=41)
            following = await page.call("play.next_level", play=number)
            _, views = await play(page, [], game="maze", mode="easy", level_seed=42)
            assert following.parts == views[0].parts
            assert without_pictures(following) == without_pictures(views[0])
            assert (await page.call("play.trace", play=number)).result["level_seed"] == 42
            last, _ = await play(page, [], game="maze", mode="easy", level_seed=2147483646)
            with pytest.raises(PageError, match="is the last one"):
                await page.call("play.next_level", play=last)
            only, _ = await play(page, [], game="coinrun", mode="exploration")
            with pytest.raises(PageError, match="the only one of this mode"):
                await page.call("play.next_level", play=only)
            with pytest.raises(PageError, match="4 plays, which is the limit") as raised:
                for _ in range(2):
                    await play(page, [], game="maze", mode="easy", level_seed=1)
            assert raised.value.code == "RESOURCE_EXHAUSTED"

    run(test())


@pytest.mark.parametrize(
    ("name", "environments"),
    [("coinrun.hard.mono", 2), ("maze.easy.sequential", 2), ("bigfish.easy.forced", 1)],
)
def test_recordings_of_upstream_are_replayed_environment_by_environment(
    server: WebServer, name: str, environments: int
) -> None:
    contents, header, actions = golden(name)
    count = header["num_envs"]

    async def test() -> None:
        async with open_page(server.url) as page:
            for environment in range(min(environments, count)):
                chosen = {"environment": environment, "human_size_px": 0}
                opened = (await page.call("replay.open", contents, **chosen)).result
                assert opened["difference"] is None
                assert opened["rows"] == header["steps"] + 1
                own = [255 if it == -1 else it for it in opened["actions"]]
                assert own == actions[environment::count]
                assert opened["header"]["env_count"] == count
                assert opened["header"]["environment"] == environment
                trace = await page.call("replay.trace", replay=opened["replay"])
                assert trace.parts["trace"] == contents
            with pytest.raises(PageError, match=f"environment is {count}, the trace has {count}"):
                await page.call("replay.open", contents, environment=count)

    run(test())


def test_a_replay_plays_forward_and_backward(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            actions = _ACTIONS + _ACTIONS[::-1]
            number, views = await play(
                page, actions, game="bigfish", mode="easy", level_seed=7, human_size_px=64
            )
            trace = (await page.call("play.trace", play=number)).parts["trace"]
            for opened in (
                await page.call("replay.open", trace, human_size_px=64),
                await page.call("replay.open", play=number, human_size_px=64),
            ):
                facts = opened.result
                assert facts["difference"] is None and facts["rows"] == len(views)
                assert facts["actions"] == actions
                assert facts["rewards"] == [view.result["reward"] for view in views]
                assert facts["first"] == [i for i, it in enumerate(views) if it.result["first"]]
                assert facts["fingerprint"] == views[-1].result["fingerprint"]
                assert facts["level_seeds"] == [[0, 7]]
                rows = [*range(0, 240, 23), *range(240, 0, -17), 0, 1, 2, 1, 0, 65, 64, 63, 240]
                for row in rows:
                    view = await page.call("replay.seek", replay=facts["replay"], row=row)
                    assert view.parts == views[row].parts, row
                    assert without_pictures(view) == without_pictures(views[row]), row
                with pytest.raises(PageError, match="row is 241, the replay has rows 0 to 240"):
                    await page.call("replay.seek", replay=facts["replay"], row=241)
                await page.call("replay.close", replay=facts["replay"])

    run(test())


@pytest.mark.parametrize("row", [0, 20, 70, 120])
def test_a_play_continues_a_trace_from_any_row(server: WebServer, row: int) -> None:
    async def test() -> None:
        chosen = {"game": "bigfish", "mode": "easy", "level_seed": 7, "human_size_px": 64}
        async with open_page(server.url) as page:
            number, views = await play(page, _ACTIONS, **chosen)
            ends = [i for i, view in enumerate(views) if view.result["first"]]
            assert len(ends) > 1, "episodes end on the way"
            trace = (await page.call("play.trace", play=number)).parts["trace"]
            begun = await page.call("play.start", trace, row=row, human_size_px=64)
            assert begun.result.pop("header")["games"] == ["bigfish"]
            branch = begun.result["play"]
            for _ in range(2):  # Restart returns to the row.
                assert begun.parts == views[row].parts
                assert without_pictures(begun) == without_pictures(views[row])
                for i, action in enumerate(_ACTIONS[row:], start=row + 1):
                    view = await page.call("play.step", play=branch, action=action)
                    assert view.parts == views[i].parts, i
                    assert without_pictures(view) == without_pictures(views[i]), i
                assert (await page.call("play.trace", play=branch)).parts["trace"] == trace
                begun = await page.call("play.restart", play=branch)
            following = await page.call("play.next_level", play=branch)
            assert following.result["step"] == 0 and following.result["level_seed"] == 8

    run(test())


def test_a_play_continues_an_environment_of_a_trace_of_several(server: WebServer) -> None:
    contents, header, _ = golden("miner.memory.levels200")
    environment, row = 2, 40

    async def test() -> None:
        async with open_page(server.url) as page:
            chosen = {"environment": environment, "human_size_px": 0}
            opened = (await page.call("replay.open", contents, **chosen)).result
            assert opened["header"]["options"]["rand_seed"] == header["options"]["rand_seed"]
            play = (await page.call("play.start", contents, row=row, **chosen)).result
            assert play["header"] == opened["header"]
            for i in range(row, row + 25):
                view = await page.call("play.step", play=play["play"], action=opened["actions"][i])
                shown = await page.call("replay.seek", replay=opened["replay"], row=i + 1)
                assert view.parts == shown.parts, i
                assert without_pictures(view) == without_pictures(shown), i

    run(test())


def test_a_play_continues_no_row_that_a_trace_has_not(server: WebServer) -> None:
    contents, header, _ = golden("coinrun.easy.solved-1001")
    steps = header["steps"]

    async def test() -> None:
        async with open_page(server.url) as page:
            for trace, members, message in (
                (contents, {"row": steps + 1}, f"row is {steps + 1}, .* 0 to {steps}"),
                (contents, {}, "row is missing"),
                (contents, {"row": 3, "game": "maze"}, "'game' is no member"),
                (contents, {"row": 3, "environment": 99}, "environment is 99, the trace has"),
                (b"none", {"row": 3}, "the file is not a trace"),
            ):
                with pytest.raises(PageError, match=message) as raised:
                    await page.call("play.start", trace, **members)
                assert raised.value.code == "INVALID_ARGUMENT"
            with pytest.raises(PageError, match="play.start takes one part"):
                await page.call("play.start", contents, contents, row=3)
            for _ in range(4):
                await page.call("play.start", contents, row=3, human_size_px=0)
            with pytest.raises(PageError, match="the page has 4 plays"):
                await page.call("play.start", contents, row=3)

    run(test())


def test_a_diverging_recording_is_reported_by_row(server: WebServer) -> None:
    contents, header, actions = golden("coinrun.easy.solved-1001")
    steps = header["steps"]
    rewards_at = contents.index(b"\n") + 1 + steps
    row = 5
    at = rewards_at + 4 * row
    changed = contents[:at] + b"\x00\x00\x80\x3f" + contents[at + 4 :]

    async def test() -> None:
        async with open_page(server.url) as page:
            opened = await page.call("replay.open", changed, human_size_px=0)
            assert opened.result["difference"] == {
                "row": row, "field": "reward", "expected": 1.0, "got": 0.0,
            }  # fmt: skip
            assert opened.result["rewards"][row] == 0

    run(test())


def test_invalid_traces_are_rejected(server: WebServer) -> None:
    contents, header, _ = golden("coinrun.easy.solved-1001")
    line, arrays = contents[: contents.index(b"\n")], contents[contents.index(b"\n") :]

    def changed(**members: Any) -> bytes:
        return json.dumps({**json.loads(line), **members}).encode() + arrays

    options = header["options"]
    rejected = {
        b"\x89PNG": "the file is not a trace",
        contents[:-1]: "the file ends within array prev_level_complete",
        changed(format="procgen-trace-2"): "must be procgen-trace-1",
        changed(num_envs=10**9): "the file ends within array",
        changed(options={**options, "env_name": "chess"}): "chess",
        changed(options={**options, "num_levels": -1}): "num_levels is -1",
        changed(options={**options, "distribution_mode": "memory"}): "coinrun",
        line + b"\n" + b"\x0f" + arrays[2:]: "the trace has action 15, allowed: -1 to 14",
    }

    async def test() -> None:
        async with open_page(server.url) as page:
            for file, message in rejected.items():
                with pytest.raises(PageError) as raised:
                    await page.call("replay.open", file)
                assert message in str(raised.value), (message, raised.value)
            steps = 100001
            sizes = [["action", "u1", steps]] + [
                [name, type_, steps + 1] for name, type_, _ in header["arrays"][1:]
            ]
            long = changed(steps=steps, arrays=sizes)[: -len(arrays)] + b"\n" + bytes(
                steps + (steps + 1) * (4 + 1 + 4 + 4 + 1)
            )
            with pytest.raises(PageError, match="100001 steps, allowed: at most 100000"):
                await page.call("replay.open", long)

    run(test())


def test_the_gallery_shows_what_is_played(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client:
            async with open_page(server.url) as page:
                shown = await page.call(
                    "gallery.page", game="jumper", mode="easy", first_level_seed=30, count=5,
                    size_px=96, options={"use_backgrounds": False},
                )  # fmt: skip
                assert shown.result["level_seeds"] == [30, 31, 32, 33, 34]
                assert [entry["level_seed"] for entry in shown.entries] == [30, 31, 32, 33, 34]
                assert client.list_pools() == []
                for seed in (30, 33):
                    _, views = await play(
                        page, [], game="jumper", mode="easy", level_seed=seed, human_size_px=96,
                        options={"use_backgrounds": False},
                    )  # fmt: skip
                    assert views[0].parts["human"] == shown.parts[f"level-{seed}"]
                one = await page.call(
                    "gallery.page", game="coinrun", mode="exploration", count=1, size_px=64
                )
                assert len(one.parts) == 1

    run(test())


def test_every_game_and_mode_is_in_the_gallery(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url, says_hello=False) as page:
            games = (await page.call("hello")).result["catalog"]["games"]
            for game in games:
                for mode in game["modes"]:
                    seed = {} if "level_seed" in mode else {"first_level_seed": 0}
                    shown = await page.call(
                        "gallery.page", game=game["name"], mode=mode["name"], count=1, size_px=64,
                        **seed,
                    )  # fmt: skip
                    assert len(shown.parts) == 1

    run(test())
