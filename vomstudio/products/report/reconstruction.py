"""Report of a reconstruction as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.io.models.reconstruction_file import result_registration
from vomstudio.products.report.page import heading, html_page, number, table
from vomstudio.products.report.residual_map import embed_figure, residual_map
from vomstudio.registration.summary import summarize_registration


def write_report(path: str | Path, result: Mapping[str, Any]) -> None:
    """Write the report on the `result` of a reconstruction as an HTML file.

    Raises
    ------
    TargetError
    """
    title = tr("Model of {folder}", folder=Path(str(result["folder"])).name)
    body = "".join(
        [
            _summary(result),
            *(f'<p class="note">{escape(_sentence(note))}</p>' for note in result["warnings"]),
            _picture(result),
            heading(tr("Survey")),
            _survey(result["survey"]),
            heading(tr("Photos")),
            _photos(result),
            heading(tr("Cameras")),
            *map(_camera, result["calibration"]),
            heading(tr("Registration")),
            _registration(result),
            heading(tr("Model")),
            _facts(result["model"], "m" if result["scaled"] else tr("units")),
            heading(tr("Time, memory, settings")),
            _times(result),
            _facts({**result["settings"], **result["versions"]}),
        ]
    )
    with atomic_write(path, True) as temporary:
        temporary.write_text(html_page(title, body), encoding="utf-8")


def _summary(result: Mapping[str, Any]) -> str:
    frame = result["frame"]
    if frame == "local":
        frame = tr(FRAME_NAMES["scaled" if result["scaled"] else "arbitrary"])
    findings = (
        Finding(
            "reconstruction.aligned",
            registered=result["registered"],
            photos=result["photos"],
            error_px=result["reprojection_error_px"],
        ),
        Finding(
            "reconstruction.tie-points",
            tie_points=result["tie_points"],
            in_three=result["tie_points_of_3"],
        ),
        Finding(
            "reconstruction.size",
            points=result["dense_points"],
            faces=result["faces"],
            frame=frame,
        ),
    )
    return f"<p>{escape(' '.join(map(_sentence, findings)))}</p>"


def _sentence(note: str | Finding | Mapping[str, Any]) -> str:
    """Return the sentence of a warning, which may be a text or a finding."""
    return str(note["message"]) if isinstance(note, Mapping) else str(note)


def _survey(survey: Mapping[str, Any]) -> str:
    findings = "".join(f"<li>{escape(finding['message'])}</li>" for finding in survey["findings"])
    advice_items = "".join(f"<li>{escape(text)}</li>" for text in survey["next_time"])
    text = f"<p>{escape(survey['verdict'])}</p>"
    if findings:
        text += f"<ul>{findings}</ul>"
    return text + (
        f"<p>{escape(tr('Next time:'))}</p><ul>{advice_items}</ul>" if advice_items else ""
    )


def _photos(result: Mapping[str, Any]) -> str:
    placed_rows = [row for row in result["photo_rows"] if row["placed"]]
    typical_error_px = (
        float(np.median([row["error_px"] for row in placed_rows])) if placed_rows else 0.0
    )
    rows = []
    for row in result["photo_rows"]:
        is_poor = (
            not row["placed"]
            or row["error_px"] > 2.0 * typical_error_px
            or row.get("is_weak", False)
        )
        position_error = row.get("position_error95_m") or row.get("position_error95")
        rows.append(
            (
                "out" if is_poor else "",
                [
                    row["name"],
                    f"{row['width']} × {row['height']}",
                    row["camera"] or tr("unknown"),
                    f"{row['tie_points']:,}" if row["placed"] else tr("not aligned"),
                    number(row["error_px"], 2),
                    number(row.get("gsd") if row["gsd_m"] is None else row["gsd_m"], 4),
                    number(row["exposure"], 2),
                    number(row["residual_m"], 2),
                    number(position_error, 4),
                    number(row.get("rotation_error95_deg"), 3),
                ],
            )
        )
    return table(
        [
            tr("photo"),
            tr("size"),
            tr("camera"),
            tr("tie points"),
            tr("error, px"),
            tr("GSD, m") if result["scaled"] else tr("GSD, units"),
            tr("exposure gain"),
            tr("GPS residual, m"),
            tr("position ± (95 %), m") if result["scaled"] else tr("position ± (95 %), units"),
            tr("rotation ± (95 %), °"),
        ],
        rows,
    )


def _camera(camera: Mapping[str, Any]) -> str:
    names = camera["names"]
    rows = []
    for index, name in enumerate(names):
        sigma = camera["sigma"][index]
        error_text = (
            tr("unknown") if sigma is None else tr("fixed") if sigma == 0 else f"± {sigma:.2g}"
        )
        rows.append(("", [name, f"{camera['params'][index]:.6g}", error_text]))
    photos = tr_n("{count} photo.", "{count} photos.", camera["photos"])
    text = (
        f"<h3>{escape(str(camera['camera'] or tr('unknown camera')))}</h3>"
        f"<p>{escape(camera['model'])}, {camera['width']} × {camera['height']}, "
        f"{escape(photos)} {escape(camera['rule'])}</p>"
        + table([tr("parameter"), tr("value"), tr("standard error")], rows)
    )
    correlation = camera["correlation"]
    if correlation:
        free_parameters = camera["free"]
        text += f"<p>{escape(tr('Correlation'))}</p>" + table(
            ["", *free_parameters],
            [
                ("", [free_parameters[i], *(f"{value:+.2f}" for value in line)])
                for i, line in enumerate(correlation)
            ],
        )
    return text


def _registration(result: Mapping[str, Any]) -> str:
    """Describe the registration with its accuracy, warnings, decisions and points."""
    registration = result["registration"]
    summary = summarize_registration(result_registration(result, ""))
    facts = [(tr("Coordinate system"), str(registration["crs"]))] if registration.get("crs") else []
    if registration.get("heights"):
        facts.append((tr("Heights"), _plain_text(registration["heights"])))
    if reason := registration.get("refused"):
        findings = (
            Finding("reconstruct.local-frame", reason=_sentence(reason)),
            Finding("reconstruct.register-later"),
        )
        text = "".join(f"<p>{escape(finding.message)}</p>" for finding in findings)
    else:
        text = f"<p>{escape(summary.rotation.message)}</p>" if summary.rotation else ""
    facts += [(fact.name, fact.text) for fact in summary.facts]
    text += table(["", ""], [("", fact) for fact in facts])
    warnings = dict.fromkeys(map(_sentence, (*registration.get("warnings", ()), *summary.warnings)))
    text += "".join(f'<p class="note">{escape(warning)}</p>' for warning in warnings)
    if decisions := registration.get("decisions"):
        text += f"<p>{escape(' '.join(map(_sentence, decisions)))}</p>"
    return (
        text
        + residual_map(registration, result["scaled"])
        + _points(registration.get("points", []))
    )


def _points(points: Sequence[Mapping[str, Any]]) -> str:
    """Build the table of control and check points with their residuals."""
    if not points:
        return ""
    rows = []
    for point in points:
        misclosure = point["residual_m"] or (None, None, None)
        cells = [point["label"], _plain_text(point["role"]), str(point["photos"])]
        cells += [number(value, 3) for value in misclosure] + [number(point["residual_px"], 2)]
        rows.append(("out" if point["role"] in ("left out", "unseen") else "", cells))
    caption = tr("Residuals: model minus survey")
    return f"<p>{escape(caption)}</p>" + table(
        [
            tr("point"),
            tr("used as"),
            tr("photos"),
            tr("east, m"),
            tr("north, m"),
            tr("up, m"),
            tr("error, px"),
        ],
        rows,
    )


LABELS = {
    "points": to_translate("points"),
    "faces": to_translate("triangles"),
    "texture_pages": to_translate("texture pages"),
    "texel": to_translate("size of a texture pixel, {unit}"),
    "texel_ratio": to_translate("texture pixel size, 90th percentile, photo pixels"),
    "share_of_the_surface_that_no_photo_sees": to_translate(
        "share of the surface not visible in any photo"
    ),
    "quality": to_translate("quality"),
    "control": to_translate("control points"),
    "marks": to_translate("marks"),
    "threads": to_translate("threads"),
    "seed": to_translate("seed"),
    "alignment": to_translate("alignment"),
    "joined": to_translate("joining of components"),
    "frame": to_translate("registration"),
    "straight": to_translate("undistortion"),
    "depths": to_translate("depth maps"),
    "cloud": to_translate("fusion"),
    "surface": to_translate("surface"),
    "texture": to_translate("texture"),
}
"""Labels of the figures, settings and stages of a result; other keys are unchanged."""
FRAME_NAMES = {
    "scaled": to_translate("a local frame"),
    "arbitrary": to_translate("a local frame, without scale or north"),
}
"""Names of the frames of models that were not registered in a coordinate system."""
_VALUE_TEXTS = {
    "above sea level": to_translate("above sea level"),
    "above the ellipsoid": to_translate("above the ellipsoid"),
    "control": to_translate("control"),
    "check": to_translate("check"),
    "left out": to_translate("left out"),
    "unseen": to_translate("unseen"),
}
"""Texts for words that occur as values in a result."""


def _label(key: str, unit: str = "m") -> str:
    if key not in LABELS:
        return key.replace("_", " ")
    label = LABELS[key]
    return tr(label, unit=unit) if "{unit}" in label else tr(label)


def _facts(values: Mapping[str, Any], unit: str = "m") -> str:
    rows = []
    for key, value in values.items():
        if value is None:
            continue
        label = _label(str(key), unit)
        if isinstance(value, Mapping):
            rows += [
                ("", [tr("{figure}, {part}", figure=label, part=_label(name)), _plain_text(item)])
                for name, item in value.items()
            ]
        else:
            rows.append(("", [label, _plain_text(value)]))
    return table(["", ""], rows)


def _plain_text(value: Any) -> str:
    if isinstance(value, bool):
        return tr("yes") if value else tr("no")
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, int):
        return f"{value:,}"
    return tr(_VALUE_TEXTS[value]) if value in _VALUE_TEXTS else str(value)


def _times(result: Mapping[str, Any]) -> str:
    rows = [
        ("", [_label(stage), f"{seconds:.1f} s"]) for stage, seconds in result["seconds"].items()
    ]
    total_s = sum(result["seconds"].values())
    rows.append(("", [tr("total"), f"{total_s:.1f} s"]))
    rows.append(("", [tr("peak memory"), f"{result['peak_memory_mb']:,.0f} MB"]))
    return table(["", ""], rows)


def _picture(result: Mapping[str, Any]) -> str:
    """Draw the cameras and tie points from above and from the side."""
    from matplotlib.figure import Figure

    drawing = result["drawing"]
    cloud, cameras, view_directions = (np.asarray(drawing[k]) for k in ("points", "at", "looks"))
    background = np.asarray(drawing.get("background", ()))
    figure = Figure(figsize=(9.5, 4.2), layout="constrained")
    unit = "m" if result["scaled"] else tr("model units")
    sides = ((0, 1, "xy", tr("from above")), (0, 2, "xz", tr("from the south")))
    for axes, (i, j, names, title) in zip(figure.subplots(1, 2), sides, strict=True):
        if len(cloud):
            axes.plot(cloud[:, i], cloud[:, j], ",", color="#999999", rasterized=True)
        if len(background):
            axes.plot(background[:, i], background[:, j], ",", color="#d55e00", rasterized=True)
        axes.quiver(
            cameras[:, i],
            cameras[:, j],
            view_directions[:, i],
            view_directions[:, j],
            color="#0072b2",
            width=0.004,
            scale=18.0,
            pivot="tail",
        )
        axes.plot(cameras[:, i], cameras[:, j], "o", color="#0072b2", markersize=3.0)
        axes.set_aspect("equal", "datalim")
        axes.set_xlabel(f"{names[0]}, {unit}")
        axes.set_ylabel(f"{names[1]}, {unit}")
        axes.set_title(title)
    caption = tr(
        "Cameras (blue, with view directions) and tie points (grey), relative to the origin of "
        "the frame."
    )
    if len(background):
        caption += " " + tr("Tie points of the background are orange.")
    return embed_figure(figure, caption)
