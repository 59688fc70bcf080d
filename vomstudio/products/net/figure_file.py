"""A figure drawn and written, the same file for the same contents."""

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

Drawn = TypeVar("Drawn")

FORMATS = ("svg", "pdf", "png")
"""Of figures. Pages with pictures on them are also written as JPEG."""
_HOW: Mapping[str, dict[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
    "png": {"metadata": {}},
    # Thin coloured lines keep their colour.
    "jpeg": {"pil_kwargs": {"quality": 92, "subsampling": 0}},
}
_OTHER_SCRIPTS = (
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
# matplotlib's settings are of the process: two threads that write would change each other's.
_SETTINGS = threading.Lock()


def write_figure(
    target: str | Path | IO[bytes],
    draw: Callable[[Figure], Drawn],
    *,
    format: str,
    size_mm: tuple[float, float] | Callable[[], tuple[float, float]],
    paper: str,
    dpi: float,
    settings: Mapping[str, Any] | None = None,
) -> Drawn:
    """Write what `draw` puts on a figure as svg, pdf, png or jpeg, without a date or names drawn by
    chance; text stays text in svg and pdf. Returns what `draw` does.

    size_mm : width and height, or what finds them out with these settings; settings : matplotlib's,
    while it is drawn and written
    Raises UsageError for another format.
    """
    if format not in _HOW:
        raise UsageError(Finding("option.not-a-choice", value=format, choices=FORMATS))
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    kept: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "vomstudio"}
    kept = kept | dict(settings or {})
    if others := fonts_of_other_scripts():
        kept["font.family"] = [*kept.get("font.family", ["DejaVu Sans"]), *others]
    with _SETTINGS, rc_context(kept):
        width, height = size_mm() if callable(size_mm) else size_mm
        figure = Figure(figsize=(width / 25.4, height / 25.4), dpi=dpi)
        FigureCanvasAgg(figure)
        figure.set_facecolor(paper)
        drawn = draw(figure)
        for words in figure.findobj(Text):
            words.set_text(replace_control_characters(words.get_text()))
        figure.savefig(target, format=format, dpi=dpi, facecolor=paper, **_HOW[format])
    return drawn


@cache
def fonts_of_other_scripts() -> tuple[str, ...]:
    """Of those that have the signs which matplotlib's own font lacks, what is installed."""
    from matplotlib.font_manager import fontManager

    installed = {font.name for font in fontManager.ttflist}
    return tuple(name for name in _OTHER_SCRIPTS if name in installed)


def sizes_of(style: NetStyle) -> dict[str, Any]:
    """matplotlib's sizes in a style, for figures with axes of its own kind."""
    return {"font.size": style.font_pt, "axes.linewidth": style.line_pt}


def font_of(style: NetStyle) -> dict[str, Any]:
    """matplotlib's setting of a style's letters."""
    return {"font.family": [style.family, "DejaVu Sans"]} if style.family else {}
