"""One-page field sheet of a photo survey with the plan, figures, drawings and reminders."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.files.extensions import check_extension
from vomstudio.core.words import to_translate, tr
from vomstudio.photogrammetry.survey.plan_forecast import forecast_summary
from vomstudio.photogrammetry.survey.survey_resolution import planes_summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vomstudio.photogrammetry.survey.planning import SurveyPlan

FORMATS = (".pdf", ".svg", ".html")
TITLE = to_translate("Photo survey: field sheet")
INK, FACE_COLOR = "#202020", "#efe9df"
PERPENDICULAR_COLOR, OBLIQUE_COLOR, CONTROL_COLOR = "#1f5fa8", "#c25e00", "#1b7f3b"
"""Colours of photos and control points on the sheet and in the window."""
_BOTTOM_MARGIN, _LINE_HEIGHT, _PARAGRAPH_GAP = 0.027, 0.0138, 0.003
"""Lower margin, and heights of a line and of the gap below a reminder, as shares of the page."""
_KIND_NAMES = {
    "perpendicular": to_translate("perpendicular"),
    "oblique": to_translate("oblique"),
    "control": to_translate("control"),
    "check": to_translate("check"),
}
"""Kinds of photos and uses of control points, keyed by their names in the plan."""


def check_format(path: str | Path) -> str:
    """Return the extension of a sheet.

    Raises
    ------
    UsageError
        If the extension is not supported.
    """
    return check_extension(path, FORMATS)


def write_field_sheet(path: str | Path, plan: SurveyPlan, *, force: bool = False) -> None:
    """Write the sheet in the format given by the extension.

    Raises
    ------
    UsageError, TargetError
    """
    from vomstudio.core.files.atomic import atomic_write

    suffix = check_format(path)
    with atomic_write(path, force) as temporary:
        if suffix == ".html":
            temporary.write_text(_html(plan), encoding="utf-8")
        else:
            _save(draw_field_sheet(plan), temporary, suffix[1:])


def _save(figure: Figure, target: Any, format_: str) -> None:
    """Save without a date or random names, so that the same plan gives the same file."""
    from matplotlib import rc_context

    metadata = {"CreationDate": None} if format_ == "pdf" else {"Date": None}
    with rc_context({"svg.hashsalt": "vomstudio"}):
        figure.savefig(target, format=format_, metadata=metadata)


def draw_field_sheet(plan: SurveyPlan, *, has_only_drawings: bool = False) -> Figure:
    """Draw the sheet in A4 portrait format, or only its two drawings."""
    from matplotlib.figure import Figure

    height = 6.0 if has_only_drawings else 11.69
    figure = Figure(figsize=(8.27, height))
    lines = [_wrap(line, 112) for line in _reminders(plan)]
    # The drawings fill the page down to the reminders.
    reminders_top = _BOTTOM_MARGIN + sum(
        _LINE_HEIGHT * len(parts) + _PARAGRAPH_GAP for parts in lines
    )
    bottom, top = (0.08, 0.94) if has_only_drawings else (reminders_top + 0.045, 0.785)
    # Leave half an inch between the drawings for the tick labels of the upper one.
    total_height = (top - bottom - 0.5 / height) / 2
    for low, is_above in ((top - total_height, False), (bottom, True)):
        # Printers leave a margin of about 5 mm.
        _draw(figure.add_axes((0.11, low, 0.85, total_height)), plan, is_plan_view=is_above)
    if not has_only_drawings:
        _add_text(figure, tr(TITLE), 0.965, 15.0, weight="bold")
        for i, (name, value) in enumerate(figures(plan)):
            x, y = 0.07 + 0.46 * (i % 2), 0.935 - 0.0195 * (i // 2)
            figure.text(x, y, name, fontsize=9.0, color="#606060", va="top")
            figure.text(x + 0.15, y, value, fontsize=9.0, color=INK, va="top")
        y = reminders_top
        for parts in lines:
            for k, part in enumerate(parts):
                figure.text(0.07 if k == 0 else 0.09, y, part, fontsize=8.5, color=INK, va="top")
                y -= _LINE_HEIGHT
            y -= _PARAGRAPH_GAP
    return figure


def _draw(axes: Axes, plan: SurveyPlan, *, is_plan_view: bool) -> None:
    """Draw the photos as seen by the photographer or from above."""
    from matplotlib.patches import Rectangle

    depth = 0.02 * plan.distance_m if is_plan_view else plan.height_m
    low = -depth if is_plan_view else 0.0
    axes.add_patch(
        Rectangle(
            (0.0, low), plan.width_m, depth, facecolor=FACE_COLOR, edgecolor=INK, linewidth=1.0
        )
    )
    for kind, color, mark in (
        ("perpendicular", PERPENDICULAR_COLOR, "o"),
        ("oblique", OBLIQUE_COLOR, "^"),
    ):
        photos = plan.select_kind(kind)
        if not photos:
            continue
        x = [photo.along_m for photo in photos]
        y = [(photo.away_m if is_plan_view else photo.up_m) for photo in photos]
        label = tr("{kind}: {count}", kind=tr(_KIND_NAMES[kind]), count=len(photos))
        axes.plot(x, y, mark, color=color, markersize=4.0, label=label, linestyle="none")
        if len(photos) <= 400:
            scale = 0.12
            dx = [scale * (photo.target_along_m - photo.along_m) for photo in photos]
            dy = [
                scale * (-photo.away_m if is_plan_view else photo.target_up_m - photo.up_m)
                for photo in photos
            ]
            axes.quiver(
                x, y, dx, dy, angles="xy", scale_units="xy", scale=1, color=color, width=0.0018
            )
    if not is_plan_view:
        square: dict[str, Any] = {
            "marker": "s",
            "color": CONTROL_COLOR,
            "markersize": 5.0,
            "linestyle": "none",
        }
        for point in plan.control_points:
            fill_style = "full" if point.use == "control" else "none"
            axes.plot([point.along_m], [point.up_m], fillstyle=fill_style, **square)
            axes.annotate(
                point.label,
                (point.along_m, point.up_m),
                xytext=(0.5, 0.5),
                textcoords="offset fontsize",
                fontsize=7.0,
                color=CONTROL_COLOR,
            )
        first_view = plan.select_kind("perpendicular")[0]
        width_m, height_m = plan.footprint_m
        axes.add_patch(
            Rectangle(
                (first_view.along_m - width_m / 2, first_view.up_m - height_m / 2),
                width_m,
                height_m,
                fill=False,
                edgecolor=PERPENDICULAR_COLOR,
                linestyle="--",
                linewidth=0.8,
            )
        )
        axes.plot([], [], label=tr("control point"), **square)
        axes.plot([], [], fillstyle="none", label=tr("check point"), **square)
        axes.legend(
            fontsize=7.0, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False
        )
    axes.set_aspect("equal", adjustable="datalim")
    is_flat = plan.manner == "terrain"
    if is_plan_view:
        axes.set_ylabel(
            tr("above the ground, m\n(from the side)")
            if is_flat
            else tr("away from the rock, m\n(from above)"),
            fontsize=8.0,
        )
        axes.set_xlabel(tr("along the outcrop from its left end, m"), fontsize=8.0)
    else:
        axes.set_ylabel(
            tr("across, m\n(from above)") if is_flat else tr("up, m\n(from the front)"),
            fontsize=8.0,
        )
    axes.tick_params(labelsize=7.0)
    axes.margins(0.04)


def figures(plan: SurveyPlan) -> list[tuple[str, str]]:
    """Return the names and values (with units) of the figures on the sheet."""
    near_limit, far_limit = plan.depth_of_field_m
    camera = plan.camera
    width, height = plan.footprint_m
    spacing_along, spacing_up = plan.spacing_m
    return [
        (tr("Camera"), f"{camera.name[:30]}, {camera.width_px} x {camera.height_px}"),
        (tr("Lens"), tr("{focal:g} mm (do not zoom)", focal=camera.focal_mm)),
        (
            tr("Outcrop"),
            tr("{width:g} x {height:g} m", width=plan.width_m, height=plan.height_m),
        ),
        (tr("Distance"), tr("{distance:.3g} m", distance=plan.distance_m)),
        (tr("Pixel size (GSD)"), tr("{size:.3g} mm", size=1000 * plan.gsd_m)),
        (tr("Plane size, error"), planes_summary(plan.planes)),
        (tr("Footprint"), tr("{width:.3g} x {height:.3g} m", width=width, height=height)),
        (
            tr("Spacing"),
            tr("{along:.3g} m along, {up:.3g} m up", along=spacing_along, up=spacing_up),
        ),
        (tr("Overlap"), f"{100 * plan.overlap:.0f} %"),
        (
            tr("Photos"),
            tr(
                "{count}: {perpendicular} perpendicular, {oblique} oblique",
                count=len(plan.positions),
                perpendicular=len(plan.select_kind("perpendicular")),
                oblique=len(plan.select_kind("oblique")),
            ),
        ),
        (
            tr("Photos per point"),
            tr(
                "{least} or more, median {median:.0f}",
                least=plan.views_least,
                median=plan.views_median,
            ),
        ),
        (
            tr("Sharp at f/{number:g}", number=plan.f_number),
            tr("{near:.3g} m to infinity", near=near_limit)
            if far_limit is None
            else tr("{near:.3g} m to {far:.3g} m", near=near_limit, far=far_limit),
        ),
        *(
            (
                tr("Rotation (GPS)") if registration.by == "receiver" else tr("Rotation (control)"),
                forecast_summary(registration),
            )
            for registration in plan.registration
        ),
    ]


def _reminders(plan: SurveyPlan) -> list[str]:
    reminders = [
        tr(
            "Place the control points first: targets of {size:.2g} cm or more, far apart and not"
            " collinear. Measure each of them, and note its label.",
            size=100 * plan.target_size_m,
        ),
        tr("Take one photo from each position, then move on. Never turn on the spot."),
        tr("Take oblique photos (triangles) 30 degrees off the perpendicular, to prevent doming."),
        tr(
            "Keep the sun behind you, or wait for an overcast sky. Take all photos in constant"
            " light, with fixed exposure, focus and zoom."
        ),
        tr(
            "Do not use digital zoom. Use the largest JPEG size, and a tripod or short exposures"
            " to avoid blur."
        ),
        tr("Before you leave, check the set: vomstudio check PHOTOS."),
    ]
    return [
        *(f"! {warning}" for warning in plan.warnings),
        *(f"- {reminder}" for reminder in reminders),
        "   ".join(
            [
                tr("Date ____________"),
                tr("Place ______________________________"),
                tr("Weather ______________________"),
            ]
        ),
    ]


def _html(plan: SurveyPlan) -> str:
    """Build a single HTML file without external resources."""
    import io

    drawing = io.StringIO()
    _save(draw_field_sheet(plan, has_only_drawings=True), drawing, "svg")
    svg = drawing.getvalue()
    svg = svg[svg.index("<svg") :]
    rows = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
        for name, value in figures(plan)
    )
    reminders = "".join(f"<li>{html.escape(line.lstrip('-! '))}</li>" for line in _reminders(plan))
    positions = _html_table(
        (
            tr("photo"),
            tr("kind"),
            tr("along, m"),
            tr("up, m"),
            tr("away, m"),
            tr("turn, °"),
            tr("tilt, °"),
        ),
        [
            (
                position.number,
                tr(_KIND_NAMES[position.kind]),
                f"{position.along_m:.2f}",
                f"{position.up_m:.2f}",
                f"{position.away_m:.2f}",
                f"{position.turn_deg:+.0f}",
                f"{position.tilt_deg:+.0f}",
            )
            for position in plan.positions
        ],
    )
    points = _html_table(
        (tr("point"), tr("use"), tr("along, m"), tr("up, m")),
        [
            (
                control_point.label,
                tr(_KIND_NAMES[control_point.use]),
                f"{control_point.along_m:.2f}",
                f"{control_point.up_m:.2f}",
            )
            for control_point in plan.control_points
        ],
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(tr('Photo survey'))}</title>"
        "<style>body{font:14px sans-serif;max-width:50em;margin:2em auto;color:#202020}"
        "table{border-collapse:collapse}th,td{padding:.15em .8em;text-align:left;"
        "border-bottom:1px solid #ddd}svg{width:100%;height:auto}</style></head><body>"
        f"<h1>{html.escape(tr(TITLE))}</h1><table>{rows}</table>{svg}"
        f"<ul>{reminders}</ul><h2>{html.escape(tr('Control points'))}</h2>{points}"
        f"<h2>{html.escape(tr('Positions'))}</h2>{positions}</body></html>\n"
    )


def _html_table(headings: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    heading = "".join(f"<th>{heading}</th>" for heading in headings)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{heading}</tr>{body}</table>"


def _add_text(figure: Figure, text: str, y: float, size: float, **options: Any) -> None:
    figure.text(0.07, y, text, fontsize=size, color=INK, va="top", **options)


def _wrap(text: str, width: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, width) or [""]
