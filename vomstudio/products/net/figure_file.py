"""Reproducible output of figures: the same contents always give the same file."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeVar

from vomstudio.core.errors import UsageError
from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.core.findings import Finding
from vomstudio.products.net.style import NetStyle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DrawResult = TypeVar("DrawResult")

FORMATS = ("svg", "pdf", "png")
"""Formats of figures; pages with pictures can also be written as JPEG."""
_SAVE_OPTIONS: Mapping[str, dict[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
    "png": {"metadata": {}},
    # Disable chroma subsampling, so that thin coloured lines keep their colour.
    "jpeg": {"pil_kwargs": {"quality": 92, "subsampling": 0}},
}
_FALLBACK_FONTS = (
    "Noto Sans CJK SC",
    "Noto Sans CJK JP",
    "Noto Sans CJK KR",
    "Source Han Sans SC",
    "WenQuanYi Zen Hei",
    "WenQuanYi Micro Hei",
    "Droid Sans Fallback",
    "Microsoft YaHei",
    "Yu Gothic",
    "Malgun Gothic",
    "PingFang SC",
    "Hiragino Sans",
    "Apple SD Gothic Neo",
    "Noto Sans Arabic",
    "Noto Sans Devanagari",
    "Noto Sans Thai",
    "Arial Unicode MS",
)
# Matplotlib's settings are global, so concurrent writers would change each other's settings.
_SETTINGS_LOCK = threading.Lock()


def write_figure(
    target: str | Path | IO[bytes],
    draw: Callable[[Figure], DrawResult],
    *,
    format: str,
    size_mm: tuple[float, float] | Callable[[], tuple[float, float]],
    paper: str,
    dpi: float,
    settings: Mapping[str, Any] | None = None,
) -> DrawResult:
    """Write a drawing as SVG, PDF, PNG or JPEG, without a date or random names.

    Text remains editable in SVG and PDF.

    Parameters
    ----------
    target : str, Path or binary file
    draw : callable
        Function that draws on a figure; its result is returned.
    format : str
    size_mm : (float, float) or callable
        Width and height, or a function that measures them under the settings.
    paper : str
        Background colour.
    dpi : float
    settings : mapping, optional
        Matplotlib settings for drawing and writing.

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    if format not in _SAVE_OPTIONS:
        raise UsageError(Finding("option.not-a-choice", value=format, choices=FORMATS))
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    rc: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "vomstudio"}
    rc = rc | dict(settings or {})
    if fallbacks := fallback_fonts():
        rc["font.family"] = [*rc.get("font.family", ["DejaVu Sans"]), *fallbacks]
    with _SETTINGS_LOCK, rc_context(rc):
        width, height = size_mm() if callable(size_mm) else size_mm
        figure = Figure(figsize=(width / 25.4, height / 25.4), dpi=dpi)
        FigureCanvasAgg(figure)
        figure.set_facecolor(paper)
        result = draw(figure)
        for text in figure.findobj(Text):
            text.set_text(replace_control_characters(text.get_text()))
        figure.savefig(target, format=format, dpi=dpi, facecolor=paper, **_SAVE_OPTIONS[format])
    return result


@cache
def fallback_fonts() -> tuple[str, ...]:
    """Return the installed fonts that have characters which matplotlib's own font lacks."""
    from matplotlib.font_manager import fontManager

    installed_names = {font.name for font in fontManager.ttflist}
    return tuple(name for name in _FALLBACK_FONTS if name in installed_names)


def size_settings(style: NetStyle) -> dict[str, Any]:
    """Return matplotlib's size settings for a style, for figures with standard axes."""
    return {"font.size": style.font_pt, "axes.linewidth": style.line_pt}


def font_settings(style: NetStyle) -> dict[str, Any]:
    """Return matplotlib's font settings for a style."""
    return {"font.family": [style.family, "DejaVu Sans"]} if style.family else {}
