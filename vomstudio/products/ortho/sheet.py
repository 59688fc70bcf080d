"""The sheet of an orthophoto: the picture with scale bar, which way is which, and the view."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import UsageError
from vomstudio.geology.notation import format_azimuth
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import STEEP_DEG
from vomstudio.products.ortho.view_directions import View
from vomstudio.words import tr

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".pdf": "PDF"}

_INK = "#141414"
_NARROWEST = 640
_WINDS = (
    "N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
    "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW",
)  # fmt: skip


def format_of(path: str | Path) -> str:
    """Pillow's name of the format that the ending asks for. Raises UsageError."""
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise UsageError(
            tr("The format of the sheet follows from its name. Let it end in .png, .jpg or .pdf."),
            file=path,
            field="--sheet",
        )
    return FORMATS[ending]


def bar_length(width_m: float) -> float:
    """A length of 1, 2 or 5 times a power of ten, a tenth to a quarter of the picture's width."""
    return round_length(0.25 * width_m)


def end_labels(view: View) -> tuple[str, str, str]:
    """What stands at the left end, at the right end and beside the arrow that points up."""
    frame = view.frame
    azimuth = wrap360(math.degrees(math.atan2(frame.right[0], frame.right[1])))
    steep = abs(view.plunge_deg) >= STEEP_DEG
    if not view.north_known:
        left, right = (
            tr("{azimuth:03d}, local", azimuth=round(a) % 360) for a in (azimuth + 180.0, azimuth)
        )
        return left, right, "y" if steep else tr("up")
    return wind(azimuth + 180.0), wind(azimuth), "N" if steep else tr("up")


def direction_in_words(view: View) -> str:
    """Which way the viewer looks, and in which sense."""
    trend = format_azimuth(view.trend_deg, 1)
    return tr(
        "View toward {trend}/{plunge:.1f} (trend/plunge, °), {sense}",
        trend=trend,
        plunge=view.plunge_deg,
        sense=tr(view.sense),
    )


def unknown_in_words(view: View) -> str | None:
    """What a model without registration leaves unknown, in words."""
    if view.north_known:
        return None if view.metric else tr("Not registered: scale unknown")
    if view.metric:
        return tr("Not registered: north unknown")
    return tr("Not registered: north and scale unknown")


def draw_sheet(
    path: Path, rgba: npt.NDArray[np.uint8], metres_per_pixel: float, view: View
) -> None:
    """Write the sheet as a picture, PNG or JPEG; `rgba` is the orthophoto, reduced to a size for
    reading. As PDF it is written by `sheet_pdf`.

    All text is drawn beside the picture, never into it, and reads the same whichever way the view
    is flipped.
    """
    from PIL import Image, ImageDraw, ImageFont

    format_ = format_of(path)
    picture = Image.fromarray(rgba)
    enlarge = max(1, -(-_NARROWEST // max(picture.size)))
    if enlarge > 1:
        picture = picture.resize(
            (picture.width * enlarge, picture.height * enlarge), Image.Resampling.NEAREST
        )
        metres_per_pixel /= enlarge
    size = max(14, round(max(picture.size) / 70))
    font = ImageFont.load_default(size)
    pad, line = 2 * size, round(1.5 * size)
    room = max(picture.width, _NARROWEST)
    left, right, up = end_labels(view)
    unknown = unknown_in_words(view)
    text = [
        direction_in_words(view),
        *_wrapped(view.reason, round((room - pad) / (0.52 * size))),
        *([unknown] if unknown else []),
    ]
    widest = max(font.getlength(words) for words in text)
    width = max(room, math.ceil(widest)) + 2 * pad
    bottom = pad + line + picture.height
    height = bottom + pad + line * (len(text) + 2) + pad
    sheet = Image.new("RGB", (width, height), "white")
    x = (width - picture.width) // 2
    sheet.paste(picture, (x, pad + line), picture)
    draw: Any = ImageDraw.Draw(sheet)
    frame = (x - 1, pad + line - 1, x + picture.width, bottom)
    draw.rectangle(frame, outline=_INK, width=size // 12)
    # Beside a narrow picture the words of its ends keep clear of the arrow and its own.
    side = max(picture.width / 2, 3 * size + max(font.getlength(end) for end in (left, right)))
    draw.text((x + picture.width / 2 - side, pad // 2), left, _INK, font)
    draw.text((x + picture.width / 2 + side, pad // 2), right, _INK, font, anchor="ra")
    _arrow(draw, width // 2, pad // 2, size, up, font)
    length = bar_length(picture.width * metres_per_pixel)
    words = bar_text(length, metric=view.metric)
    _bar(draw, x, bottom + pad // 2, words, length / metres_per_pixel, size, font)
    x_words = min(x, width - pad - widest)
    for i, words in enumerate(text):
        draw.text((x_words, bottom + pad // 2 + round(line * (i + 2.2))), words, _INK, font)
    sheet.save(path, format_)


def _arrow(draw: Any, x: int, y: int, size: int, label: str, font: Any) -> None:
    half = size // 3
    draw.polygon(((x, y), (x - half, y + size // 2), (x + half, y + size // 2)), _INK)
    draw.line((x, y + size // 2, x, y + size + half), _INK, size // 8)
    draw.text((x + 2 * half, y), label, _INK, font)


def _bar(draw: Any, x: int, y: int, length: str, pixels: float, size: int, font: Any) -> None:
    """Two halves, dark and light, with 0 and the length at their ends; of a short one the length
    stands beside the 0."""
    thick = size // 3
    draw.rectangle((x, y, x + pixels, y + thick), "white", _INK)
    draw.rectangle((x, y, x + pixels / 2, y + thick), _INK, _INK)
    below = y + 1.5 * thick
    draw.text((x, below), "0", _INK, font)
    end = max(pixels, font.getlength("0 ") + font.getlength(length) / 2)
    draw.text((x + end, below), length, _INK, font, anchor="ma")


def wind(azimuth_deg: float) -> str:
    whole = round(azimuth_deg) % 360
    return f"{_WINDS[round(azimuth_deg / 22.5) % 16]} ({whole:03d})"


def _wrapped(text: str, width: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, width)
