"""Images of whole levels, and the paths of agents through them."""

from __future__ import annotations

import asyncio
import io
from typing import Any

import numpy as np
import pytest
from page import Answer, Page, WebServer, open_page
from PIL import Image

# Solves level 1000 of coinrun: waits, runs, jumps and runs to the coin.
_TO_THE_COIN = [4] + [7] * 2 + [8] * 18 + [7] * 14


def pixels(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png)))


async def play(page: Page, actions: list[int], **level: Any) -> Answer:
    """Plays a level and returns its trace."""
    number = (await page.call("play.start", mode="easy", **level)).result["play"]
    for action in actions:
        await page.call("play.step", play=number, action=action)
    return await page.call("play.trace", play=number)


def test_the_gallery_shows_whole_levels(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            levels = {"game": "coinrun", "mode": "easy", "first_level_seed": 5, "count": 2}
            level = await page.call("gallery.page", **levels, size_px=128, whole_level=True)
            seen = await page.call("gallery.page", **levels, size_px=128)
            expected = await page.call(
                "gallery.page", **levels, size_px=128, options={"center_agent": False}
            )
            assert level.parts == expected.parts
            assert level.parts != seen.parts

    asyncio.run(test())


def test_the_map_of_a_replay_shows_the_level_and_the_path(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            actions = _TO_THE_COIN + [7] * 5
            trace = await play(page, actions, game="coinrun", level_seed=1000)
            replay = (await page.call("replay.open", trace.parts["trace"])).result
            number = replay["replay"]
            end = len(_TO_THE_COIN)
            assert replay["first"] == [0, end]
            view = await page.call("replay.seek", replay=number, row=0, map_size_px=256)
            whole = await page.call(
                "gallery.page", game="coinrun", mode="easy", first_level_seed=1000, count=1,
                size_px=256, whole_level=True,
            )  # fmt: skip
            assert view.parts["map"] == whole.parts["level-1000"]
            path = view.result["path"]
            assert path["first_row"] == 0
            # A value for each row up to the last state of the episode.
            assert len(path["x"]) == len(path["y"]) == end + 1
            assert all(0 <= value <= 1 for value in path["x"] + path["y"])
            assert path["x"][end] > path["x"][0]

            # The agent is where the path says: what changes in the image changes around there.
            before, after = [
                await page.call("replay.seek", replay=number, row=row, map_size_px=256)
                for row in (0, 6)
            ]
            changed = np.argwhere(pixels(before.parts["map"]) != pixels(after.parts["map"]))
            rows, columns = changed[:, 0] / 256, changed[:, 1] / 256
            cell = 1 / 64
            assert np.abs(columns - path["x"][0]).min() < cell
            assert np.abs(columns - path["x"][6]).min() < cell
            assert np.abs(rows - path["y"][6]).min() < cell

            # The next episode has a path of its own.
            after = await page.call("replay.seek", replay=number, row=end, map_size_px=64)
            assert after.result["path"]["first_row"] == end
            assert after.result["path"]["x"][0] == pytest.approx(path["x"][0])
            assert len(after.result["path"]["x"]) == replay["rows"] - end
            plain = await page.call("replay.seek", replay=number, row=end)
            assert "path" not in plain.result and "map" not in plain.parts

    asyncio.run(test())


def test_the_path_is_exact_where_the_agent_moves_by_whole_cells(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            trace = await play(page, [7, 5, 1, 3] * 10, game="maze", level_seed=3)
            replay = (await page.call("replay.open", trace.parts["trace"])).result
            view = await page.call("replay.seek", replay=replay["replay"], row=3, map_size_px=64)
            path = np.array([view.result["path"]["x"], view.result["path"]["y"]])
            moves = np.abs(np.diff(path))
            size = moves[moves > 0].min()
            assert np.allclose(moves[moves > 0], size, atol=1e-4)  # a cell at a time
            assert np.isclose(1 / size, round(1 / size), atol=1e-2)

    asyncio.run(test())
