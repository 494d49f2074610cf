"""Draws a mosaic of games: a row a game, its name and pictures of some of its environments."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

_MARGIN_PX = 40
_GAP_PX = 14
_LABEL_WIDTH_PX = 250
_CORNER_RADIUS_PX = 12
_BACKGROUND = (22, 25, 32)
_NAME_COLOR = (240, 242, 246)
_DESCRIPTION_COLOR = (150, 158, 172)
_NAME_SIZE_PX = 34
_DESCRIPTION_SIZE_PX = 18
_DESCRIPTION_LINE_CHARACTERS = 24

# A game's name, what it is in one line, pictures uint8 [height, width, 3].
Row = tuple[str, str, Sequence[np.ndarray]]


def draw(rows: Sequence[Row], *, side_px: int) -> Image.Image:
    """Gives the mosaic; pictures of another size than side_px are scaled, without smoothing."""
    columns = max(len(frames) for _, _, frames in rows)
    pitch = side_px + _GAP_PX
    width = 2 * _MARGIN_PX + _LABEL_WIDTH_PX + columns * pitch - _GAP_PX
    height = 2 * _MARGIN_PX + len(rows) * pitch - _GAP_PX
    image = Image.new("RGB", (width, height), _BACKGROUND)
    corners = _rounded_square(side_px)
    for number, (name, description, frames) in enumerate(rows):
        top = _MARGIN_PX + number * pitch
        _write_label(image, name, description, top + side_px // 2)
        for column, frame in enumerate(frames):
            picture = Image.fromarray(frame)
            if picture.size != (side_px, side_px):
                picture = picture.resize((side_px, side_px), Image.Resampling.NEAREST)
            left = _MARGIN_PX + _LABEL_WIDTH_PX + column * pitch
            image.paste(picture, (left, top), corners)
    return image


def _write_label(image: Image.Image, name: str, description: str, middle: int) -> None:
    canvas = ImageDraw.Draw(image)
    lines = textwrap.wrap(description, _DESCRIPTION_LINE_CHARACTERS)
    line_height = round(1.35 * _DESCRIPTION_SIZE_PX)
    name_height = round(1.5 * _NAME_SIZE_PX)
    y = middle - (name_height + len(lines) * line_height) // 2
    canvas.text((_MARGIN_PX, y), name, _NAME_COLOR, _font("DejaVuSans-Bold.ttf", _NAME_SIZE_PX))
    y += name_height
    font = _font("DejaVuSans.ttf", _DESCRIPTION_SIZE_PX)
    for line in lines:
        canvas.text((_MARGIN_PX, y), line, _DESCRIPTION_COLOR, font)
        y += line_height


def _font(file_name: str, size_px: int) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    try:
        return ImageFont.truetype(file_name, size_px)
    except OSError:
        return ImageFont.load_default()  # Small, but there.


def _rounded_square(side_px: int) -> Image.Image:
    """Gives a mask with smooth round corners: drawn four times as large, then scaled down."""
    large = Image.new("L", (4 * side_px, 4 * side_px), 0)
    ImageDraw.Draw(large).rounded_rectangle(
        (0, 0, 4 * side_px - 1, 4 * side_px - 1), 4 * _CORNER_RADIUS_PX, fill=255
    )
    return large.resize((side_px, side_px), Image.Resampling.LANCZOS)
