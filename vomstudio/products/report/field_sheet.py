"""The plan of a photo survey on one page to take along: what to set, where to stand, what to lay
out."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vomstudio.survey.planning import SurveyPlan

FORMATS = (".pdf", ".svg", ".html")
INK, FACE = "#202020", "#efe9df"
PERPENDICULAR, OBLIQUE, CONTROL = "#1f5fa8", "#c25e00", "#1b7f3b"
"""Colours of photos and points, here and in the window."""


def check_format(path: str | Path) -> str:
    """The ending. Raises UsageError for one that no sheet has."""
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise UsageError(
            tr("the ending says how the sheet is written: .pdf, .svg or .html."),
            file=path,
            field="--output",
        )
    return ending


def write_field_sheet(path: str | Path, plan: SurveyPlan, *, force: bool = False) -> None:
    """Raises UsageError for an unknown ending, TargetError."""
    from vomstudio.files.atomic import atomic_write

    ending = check_format(path)
    with atomic_write(path, force) as temporary:
        if ending == ".html":
            temporary.write_text(_html(plan), encoding="utf-8")
        else:
            _save(draw_field_sheet(plan), temporary, ending[1:])


def _save(figure: Figure, target: Any, format_: str) -> None:
    """Without a date or names drawn by chance: the same plan gives the same file."""
    from matplotlib import rc_context

    stamp = {"CreationDate": None} if format_ == "pdf" else {"Date": None}
    with rc_context({"svg.hashsalt": "vomstudio"}):
        figure.savefig(target, format=format_, metadata=stamp)


def draw_field_sheet(plan: SurveyPlan, *, pictures_only: bool = False) -> Figure:
    """A4, upright; or only its two drawings."""
    from matplotlib.figure import Figure

    height = 6.0 if pictures_only else 11.69
    figure = Figure(figsize=(8.27, height))
    bottom, top = (0.08, 0.94) if pictures_only else (0.325, 0.785)
    # Half an inch between them, for the numbers of the upper one.
    tall = (top - bottom - 0.5 / height) / 2
    for low, above in ((top - tall, False), (bottom, True)):
        # Printers leave some 5 mm of the paper white.
        _draw(figure.add_axes((0.11, low, 0.85, tall)), plan, above=above)
    if not pictures_only:
        _text(figure, "Photo survey: field sheet", 0.965, 15.0, weight="bold")
        for i, (name, value) in enumerate(figures(plan)):
            x, y = 0.07 + 0.46 * (i % 2), 0.935 - 0.0195 * (i // 2)
            figure.text(x, y, name, fontsize=9.0, color="#606060", va="top")
            figure.text(x + 0.15, y, value, fontsize=9.0, color=INK, va="top")
        y = 0.28
        for line in _reminders(plan):
            for k, part in enumerate(_wrapped(line, 112)):
                figure.text(0.07 if k == 0 else 0.09, y, part, fontsize=8.5, color=INK, va="top")
                y -= 0.0145
            y -= 0.003
    return figure


def _draw(axes: Axes, plan: SurveyPlan, *, above: bool) -> None:
    """Seen as the photographer sees it, or from above."""
    from matplotlib.patches import Rectangle

    depth = 0.02 * plan.distance_m if above else plan.height_m
    low = -depth if above else 0.0
    axes.add_patch(
        Rectangle((0.0, low), plan.width_m, depth, facecolor=FACE, edgecolor=INK, linewidth=1.0)
    )
    for kind, color, mark in (
        ("perpendicular", PERPENDICULAR, "o"),
        ("oblique", OBLIQUE, "^"),
    ):
        some = plan.of_kind(kind)
        if not some:
            continue
        x = [s.along_m for s in some]
        y = [(s.away_m if above else s.up_m) for s in some]
        label = f"{kind}: {len(some)}"
        axes.plot(x, y, mark, color=color, markersize=4.0, label=label, linestyle="none")
        if len(some) <= 400:
            scale = 0.12
            dx = [scale * (s.target_along_m - s.along_m) for s in some]
            dy = [scale * (-s.away_m if above else s.target_up_m - s.up_m) for s in some]
            axes.quiver(
                x, y, dx, dy, angles="xy", scale_units="xy", scale=1, color=color, width=0.0018
            )
    if not above:
        square: dict[str, Any] = {
            "marker": "s", "color": CONTROL, "markersize": 5.0, "linestyle": "none"
        }  # fmt: skip
        for point in plan.control_points:
            filled = "full" if point.use == "control" else "none"
            axes.plot([point.along_m], [point.up_m], fillstyle=filled, **square)
            axes.annotate(
                point.label,
                (point.along_m, point.up_m),
                xytext=(0.5, 0.5),
                textcoords="offset fontsize",
                fontsize=7.0,
                color=CONTROL,
            )
        first = plan.of_kind("perpendicular")[0]
        w, h = plan.footprint_m
        axes.add_patch(
            Rectangle(
                (first.along_m - w / 2, first.up_m - h / 2),
                w,
                h,
                fill=False,
                edgecolor=PERPENDICULAR,
                linestyle="--",
                linewidth=0.8,
            )
        )
        axes.plot([], [], label="control point", **square)
        axes.plot([], [], fillstyle="none", label="check point", **square)
        axes.legend(
            fontsize=7.0, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False
        )
    axes.set_aspect("equal", adjustable="datalim")
    flat = plan.manner == "terrain"
    upward = ("above the ground" if flat else "away from the rock") if above else (
        "across" if flat else "up"
    )  # fmt: skip
    view = ("from the side" if flat else "from above") if above else (
        "from above" if flat else "as you face it"
    )  # fmt: skip
    axes.set_ylabel(f"{upward}, m\n({view})", fontsize=8.0)
    if above:
        axes.set_xlabel("along the outcrop from its left end, m", fontsize=8.0)
    axes.tick_params(labelsize=7.0)
    axes.margins(0.04)


def figures(plan: SurveyPlan) -> list[tuple[str, str]]:
    """Names and values with their units, as they stand on the sheet."""
    near, far = plan.depth_of_field_m
    c = plan.camera
    return [
        ("Camera", f"{c.name[:30]}, {c.width_px} x {c.height_px}"),
        ("Lens", f"{c.focal_mm:g} mm; hold it, do not zoom"),
        ("Outcrop", f"{plan.width_m:g} x {plan.height_m:g} m"),
        ("Distance", f"{plan.distance_m:.3g} m"),
        ("Pixel on the rock", f"{1000 * plan.gsd_m:.3g} mm"),
        ("Smallest plane", f"{plan.smallest_plane_m:.2g} m across"),
        ("One photo shows", f"{plan.footprint_m[0]:.3g} x {plan.footprint_m[1]:.3g} m"),
        ("Step between", f"{plan.spacing_m[0]:.3g} m along, {plan.spacing_m[1]:.3g} m up"),
        ("Overlap", f"{plan.overlap:.0%}"),
        (
            "Photos",
            f"{len(plan.stations)}: {len(plan.of_kind('perpendicular'))} perpendicular, "
            f"{len(plan.of_kind('oblique'))} oblique",
        ),
        ("Views of a place", f"{plan.views_least} or more, {plan.views_median:.0f} as a rule"),
        (
            f"Sharp at f/{plan.f_number:g}",
            f"{near:.3g} m to " + ("infinity" if far is None else f"{far:.3g} m"),
        ),
    ]


def _reminders(plan: SurveyPlan) -> list[str]:
    size = plan.target_size_m
    return [
        *(f"! {warning}." for warning in plan.warnings),
        f"- Lay out the control points before: marks of {100 * size:.2g} cm or more, far apart, "
        "not in one line; measure each, and note which is which.",
        "- One position, one photo: walk on (or fly on) before the next; never turn on the spot.",
        "- Oblique photos (triangles) are taken 30 degrees off the perpendicular, against doming.",
        "- Sun behind you or even cloud; one window of time; fixed exposure, focus and zoom.",
        "- No digital zoom; the camera's largest JPEG; a tripod or short exposures against blur.",
        "- Before leaving: vomstudio check PHOTOS says whether the set will do.",
        "Date ____________   Place ______________________________   Weather ______________________",
    ]


def _html(plan: SurveyPlan) -> str:
    """One file, without anything from elsewhere."""
    import io

    drawing = io.StringIO()
    _save(draw_field_sheet(plan, pictures_only=True), drawing, "svg")
    svg = drawing.getvalue()
    svg = svg[svg.index("<svg") :]
    rows = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
        for name, value in figures(plan)
    )
    said = "".join(f"<li>{html.escape(line.lstrip('-! '))}</li>" for line in _reminders(plan))
    places = _rows(
        ("photo", "kind", "along m", "up m", "away m", "turn deg", "tilt deg"),
        [
            (
                s.number,
                s.kind,
                f"{s.along_m:.2f}",
                f"{s.up_m:.2f}",
                f"{s.away_m:.2f}",
                f"{s.turn_deg:+.0f}",
                f"{s.tilt_deg:+.0f}",
            )
            for s in plan.stations
        ],
    )
    points = _rows(
        ("point", "use", "along m", "up m"),
        [(p.label, p.use, f"{p.along_m:.2f}", f"{p.up_m:.2f}") for p in plan.control_points],
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Photo survey</title>'
        "<style>body{font:14px sans-serif;max-width:50em;margin:2em auto;color:#202020}"
        "table{border-collapse:collapse}th,td{padding:.15em .8em;text-align:left;"
        "border-bottom:1px solid #ddd}svg{width:100%;height:auto}</style></head><body>"
        f"<h1>Photo survey: field sheet</h1><table>{rows}</table>{svg}<ul>{said}</ul>"
        f"<h2>Control points</h2>{points}<h2>Positions</h2>{places}</body></html>\n"
    )


def _rows(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    head = "".join(f"<th>{h}</th>" for h in heads)
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _text(figure: Figure, words: str, y: float, size: float, **options: Any) -> None:
    figure.text(0.07, y, words, fontsize=size, color=INK, va="top", **options)


def _wrapped(text: str, width: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, width) or [""]
