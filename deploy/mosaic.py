#!/usr/bin/env python3
"""Draws mosaics: rows of pictures with a name and a description, a caption under each picture.

As a program: mosaic.py SHEETS.json. The file lists sheets, each with the `file` to draw, its `rows`
(`name`, `description`, `pictures` with a `file` and an optional `caption`); `size_px` if all
pictures have the same size; `page_width_px` to reduce the sheet for a web page. Paths are relative
to the folder of the list.
"""

from __future__ import annotations

import argparse
import functools
import json
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

_MARGIN_PX = 40
_GAP_PX = 14
_LABEL_WIDTH_PX = 250
_NAME_WIDTH_PX = _LABEL_WIDTH_PX - _GAP_PX
_CORNER_RADIUS_PX = 12
_BACKGROUND = (22, 25, 32)
_NAME_COLOR = (240, 242, 246)
_DESCRIPTION_COLOR = (150, 158, 172)
_NAME_SIZE_PX = 34
_NAME_SIZE_LEAST_PX = 14  # of long names
_DESCRIPTION_SIZE_PX = 18
_DESCRIPTION_LINE_CHARACTERS = 24
_CAPTION_HEIGHT_PX = 26


class Picture(NamedTuple):
    """A picture with its caption."""

    frame: np.ndarray  # uint8 [height, width, 3]
    caption: str = ""


class Row(NamedTuple):
    """A row of pictures, with a name and a description to the left."""

    name: str
    description: str
    pictures: Sequence[Picture]


def draw(rows: Sequence[Row], *, size_px: int | None = None) -> Image.Image:
    """Draws the mosaic.

    With size_px all pictures are squares of that size: smaller ones are enlarged without smoothing,
    larger ones reduced. Otherwise each has its own size.
    """
    pictures = [picture for row in rows for picture in row.pictures]
    sizes = [(size_px, size_px) if size_px else p.frame.shape[1::-1] for p in pictures]
    captioned = any(picture.caption for picture in pictures)
    pitch_x = max(width for width, _ in sizes) + _GAP_PX
    pitch_y = max(height for _, height in sizes) + _GAP_PX + captioned * _CAPTION_HEIGHT_PX
    columns = max(len(row.pictures) for row in rows)
    width = 2 * _MARGIN_PX + _LABEL_WIDTH_PX + columns * pitch_x - _GAP_PX
    height = 2 * _MARGIN_PX + len(rows) * pitch_y - _GAP_PX
    image = Image.new("RGB", (width, height), _BACKGROUND)
    for number, row in enumerate(rows):
        top = _MARGIN_PX + number * pitch_y
        _write_label(image, row.name, row.description, top + (pitch_y - _GAP_PX) // 2)
        for column, picture in enumerate(row.pictures):
            left = _MARGIN_PX + _LABEL_WIDTH_PX + column * pitch_x
            _paste(image, picture, (left, top), size_px)
    return image


def _paste(image: Image.Image, picture: Picture, at: tuple[int, int], size_px: int | None) -> None:
    shown = Image.fromarray(picture.frame)
    if size_px and shown.size != (size_px, size_px):
        enlarges = shown.width < size_px
        filter_ = Image.Resampling.NEAREST if enlarges else Image.Resampling.BOX
        shown = shown.resize((size_px, size_px), filter_)
    image.paste(shown, at, _rounded(shown.size))
    if picture.caption:
        below = (at[0], at[1] + shown.height + 2)
        font = _font("DejaVuSans.ttf", _DESCRIPTION_SIZE_PX)
        ImageDraw.Draw(image).text(below, picture.caption, _DESCRIPTION_COLOR, font)


def _write_label(image: Image.Image, name: str, description: str, middle: int) -> None:
    canvas = ImageDraw.Draw(image)
    lines = textwrap.wrap(description, _DESCRIPTION_LINE_CHARACTERS)
    line_height = round(1.35 * _DESCRIPTION_SIZE_PX)
    name_height = round(1.5 * _NAME_SIZE_PX)
    y = middle - (name_height + len(lines) * line_height) // 2
    for size_px in range(_NAME_SIZE_PX, _NAME_SIZE_LEAST_PX - 1, -1):
        font = _font("DejaVuSans-Bold.ttf", size_px)
        if font.getlength(name) <= _NAME_WIDTH_PX:
            break
    canvas.text((_MARGIN_PX, y), name, _NAME_COLOR, font)
    y += name_height
    font = _font("DejaVuSans.ttf", _DESCRIPTION_SIZE_PX)
    for line in lines:
        canvas.text((_MARGIN_PX, y), line, _DESCRIPTION_COLOR, font)
        y += line_height


def _font(file_name: str, size_px: int) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    try:
        return ImageFont.truetype(file_name, size_px)
    except OSError:
        return ImageFont.load_default()  # Small, but always available.


@functools.cache
def _rounded(size: tuple[int, int]) -> Image.Image:
    """Returns a mask with antialiased round corners: drawn at four times the size, then reduced."""
    width, height = size
    large = Image.new("L", (4 * width, 4 * height), 0)
    ImageDraw.Draw(large).rounded_rectangle(
        (0, 0, 4 * width - 1, 4 * height - 1), 4 * _CORNER_RADIUS_PX, fill=255
    )
    return large.resize(size, Image.Resampling.LANCZOS)


def _for_page(image: Image.Image, width_px: int) -> Image.Image:
    """Reduces a mosaic in size and colors, for a small file."""
    size = (width_px, round(image.height * width_px / image.width))
    return image.resize(size, Image.Resampling.LANCZOS).quantize(256)


def _read_row(row: dict, folder: Path) -> Row:
    pictures = []
    for picture in row["pictures"]:
        with Image.open(folder / picture["file"]) as image:
            pictures.append(Picture(np.asarray(image.convert("RGB")), picture.get("caption", "")))
    return Row(row["name"], row["description"], pictures)


def main() -> None:
    """Draws the sheets of a list."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("list", type=Path, help="the list of sheets, a .json")
    path = parser.parse_args().list
    for sheet in json.loads(path.read_text()):
        rows = [_read_row(row, path.parent) for row in sheet["rows"]]
        image = draw(rows, size_px=sheet.get("size_px"))
        if "page_width_px" in sheet:
            image = _for_page(image, sheet["page_width_px"])
        image.save(path.parent / sheet["file"], optimize=True)
        print(path.parent / sheet["file"], flush=True)


if __name__ == "__main__":
    main()
