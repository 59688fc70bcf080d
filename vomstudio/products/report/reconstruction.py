"""The report of a reconstruction: one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.files.atomic import atomic_write

_STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { margin-bottom: .1em; } h2 { margin-top: 1.6em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: .6em 0; }
td, th { padding: .15em 1em .15em 0; text-align: left; border-bottom: 1px solid #e4e4e4; }
td { font-variant-numeric: tabular-nums; } tr.out td { background: #fbe9d0; }
.note { background: #fff6e0; border-left: 4px solid #e69f00; padding: .3em .8em; margin: .4em 0; }
img { max-width: 100%; } .small { color: #666; font-size: 13px; }
"""


def write_report(path: str | Path, result: Mapping[str, Any]) -> None:
    """Write the page for the `result` of `photogrammetry.reconstruction.reconstruct`.

    Raises TargetError.
    """
    title = f"Model of {Path(str(result['folder'])).name}"
    body = "".join(
        [
            f"<h1>{escape(title)}</h1>",
            _summary(result),
            *(f'<p class="note">{escape(text)}</p>' for text in result["warnings"]),
            _picture(result),
            "<h2>Survey</h2>",
            _survey(result["survey"]),
            "<h2>Photos</h2>",
            _photos(result),
            "<h2>Cameras</h2>",
            *map(_camera, result["calibration"]),
            "<h2>Frame</h2>",
            _registration(result),
            "<h2>Model</h2>",
            _facts(result["model"], "m" if result["scaled"] else "units"),
            "<h2>Time, memory, settings</h2>",
            _times(result),
            _facts({**result["settings"], **result["versions"]}),
        ]
    )
    page = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>{body}</body></html>\n"
    )
    with atomic_write(path, True) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _summary(result: Mapping[str, Any]) -> str:
    frame = result["frame"]
    where = frame
    if frame == "local":
        where = "a local frame" + ("" if result["scaled"] else ", without scale or north")
    return (
        f"<p>{result['registered']} of {result['photos']} photos placed with a mean reprojection "
        f"error of {result['reprojection_error_px']:.2f} px; {result['tie_points']:,} tie points "
        f"({result['tie_points_of_3']:,} seen in three photos or more); "
        f"{result['dense_points']:,} points, {result['faces']:,} faces, in {escape(where)}.</p>"
    )


def _survey(survey: Mapping[str, Any]) -> str:
    findings = "".join(f"<li>{escape(f['text'])}</li>" for f in survey["findings"])
    again = "".join(f"<li>{escape(text)}</li>" for text in survey["next_time"])
    text = f"<p>{escape(survey['verdict'])}</p>"
    if findings:
        text += f"<ul>{findings}</ul>"
    return text + (f"<p>Next time:</p><ul>{again}</ul>" if again else "")


def _table(head: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """rows: (class, cells)"""
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = "\n".join(
        f'<tr class="{kind}">' + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>"
        for kind, row in rows
    )
    return f"<table><tr>{cells}</tr>\n{lines}</table>"


def _number(value: float | None, digits: int, unit: str = "") -> str:
    return "–" if value is None or value != value else f"{value:,.{digits}f}{unit}"


def _photos(result: Mapping[str, Any]) -> str:
    placed = [row for row in result["photo_rows"] if row["placed"]]
    typical = float(np.median([row["error_px"] for row in placed])) if placed else 0.0
    rows = []
    for row in result["photo_rows"]:
        poor = not row["placed"] or row["error_px"] > 2.0 * typical
        rows.append(
            (
                "out" if poor else "",
                [
                    row["name"],
                    f"{row['width']} × {row['height']}",
                    row["camera"] or "unknown",
                    f"{row['tie_points']:,}" if row["placed"] else "not placed",
                    _number(row["error_px"], 2),
                    _number(row["gsd_m"], 4),
                    _number(row["exposure"], 2),
                    _number(row["residual_m"], 2),
                ],
            )
        )
    unit = "m" if result["scaled"] else "units"
    return _table(
        [
            *("photo", "size", "camera", "tie points", "error, px", f"GSD, {unit}"),
            *("brightened by", "GPS residual, m"),
        ],
        rows,
    )


def _camera(camera: Mapping[str, Any]) -> str:
    names = camera["names"]
    rows = []
    for number, name in enumerate(names):
        spread = camera["sigma"][number]
        kept = "unknown" if spread is None else "held" if spread == 0 else f"± {spread:.2g}"
        rows.append(("", [name, f"{camera['params'][number]:.6g}", kept]))
    text = (
        f"<h3>{escape(str(camera['camera'] or 'unknown camera'))}</h3>"
        f"<p>{escape(camera['model'])}, {camera['width']} × {camera['height']}, "
        f"{camera['photos']} photos. {escape(camera['rule'])}</p>"
        + _table(["parameter", "value", "one sigma"], rows)
    )
    correlation = camera["correlation"]
    if correlation:
        free = camera["free"]
        text += "<p>Correlation</p>" + _table(
            ["", *free],
            [
                ("", [free[i], *(f"{value:+.2f}" for value in line)])
                for i, line in enumerate(correlation)
            ],
        )
    return text


def _registration(result: Mapping[str, Any]) -> str:
    found = result["registration"]
    if refused := found.get("refused"):
        return f"<p>Local: {escape(refused)}</p>"
    facts = _facts({key: value for key, value in found.items() if not isinstance(value, list)})
    return facts + _points(found.get("points", []))


def _points(points: Sequence[Mapping[str, Any]]) -> str:
    """Control and check points with what they miss by."""
    if not points:
        return ""
    rows = []
    for point in points:
        miss = point["residual_m"] or (None, None, None)
        cells = [point["label"], point["role"], str(point["photos"])]
        cells += [_number(value, 3) for value in miss] + [_number(point["residual_px"], 2)]
        rows.append(("out" if point["role"] in ("left out", "unseen") else "", cells))
    return "<p>Model less survey</p>" + _table(
        ["point", "used as", "photos", "east, m", "north, m", "up, m", "error, px"], rows
    )


# Where the name of a figure alone does not say what it is and in which unit.
_LABELS = {
    "crs": "coordinate system",
    "rms_m": "missed by (rms), m",
    "rms_control_m": "control points missed by (rms), m",
    "rms_check_m": "check points missed by (rms), m",
    "sigma_m": "error of one coordinate (1 sigma), m",
    "scale_error": "error of the scale (1 sigma, part of it)",
    "rotation_error_deg": "error of the rotation (1 sigma), degrees",
    "texel": "size of a texture pixel, {unit}",
    "share_of_the_surface_that_no_photo_sees": "part of the surface that no photo sees",
}


def _facts(values: Mapping[str, Any], unit: str = "m") -> str:
    rows = []
    for key, value in values.items():
        if value is None:
            continue
        label = _LABELS.get(key, str(key).replace("_", " ")).format(unit=unit)
        if isinstance(value, Mapping):
            rows += [
                ("", [f"{label}, {name.replace('_', ' ')}", _plain(each)])
                for name, each in value.items()
            ]
        else:
            rows.append(("", [label, _plain(value)]))
    return _table(["", ""], rows)


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, int):
        return f"{value:,}"
    return str(value)


def _times(result: Mapping[str, Any]) -> str:
    rows = [("", [stage, f"{seconds:.1f} s"]) for stage, seconds in result["seconds"].items()]
    total = sum(result["seconds"].values())
    rows.append(("", ["together", f"{total:.1f} s"]))
    rows.append(("", ["memory at most", f"{result['peak_memory_mb']:,.0f} MB"]))
    return _table(["", ""], rows)


def _picture(result: Mapping[str, Any]) -> str:
    """Cameras and tie points from above and from the side."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    cloud, cameras, looks = (np.asarray(result["drawing"][k]) for k in ("points", "at", "looks"))
    figure = Figure(figsize=(9.5, 4.2), layout="constrained")
    unit = "m" if result["scaled"] else "units of the model"
    sides = ((0, 1, "xy", "from above"), (0, 2, "xz", "from the south"))
    for axes, (i, j, names, title) in zip(figure.subplots(1, 2), sides, strict=True):
        if len(cloud):
            axes.plot(cloud[:, i], cloud[:, j], ",", color="#999999", rasterized=True)
        axes.quiver(
            cameras[:, i], cameras[:, j], looks[:, i], looks[:, j],
            color="#0072b2", width=0.004, scale=18.0, pivot="tail",
        )  # fmt: skip
        axes.plot(cameras[:, i], cameras[:, j], "o", color="#0072b2", markersize=3.0)
        axes.set_aspect("equal", "datalim")
        axes.set_xlabel(f"{names[0]}, {unit}")
        axes.set_ylabel(f"{names[1]}, {unit}")
        axes.set_title(title)
    buffer = BytesIO()
    FigureCanvasSVG(figure).print_svg(buffer)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    text = "Cameras (blue, with their directions) and tie points (grey), less the frame's origin"
    return (
        f'<figure><img src="data:image/svg+xml;base64,{data}" alt="{text}">'
        f'<figcaption class="small">{text}</figcaption></figure>'
    )
