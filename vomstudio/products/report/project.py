"""Report of a project as one self-contained HTML file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import atomic_write, check_target
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.results import Result
from vomstudio.core.version import __version__
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.notation import format_attitude, format_error_deg
from vomstudio.geology.orientation import Line, Plane
from vomstudio.products.report.page import (
    heading,
    html_page,
    number,
    paragraph,
    svg_picture,
    table,
)
from vomstudio.project.exports.export import get_thresholds
from vomstudio.project.exports.feature_table import feature_table
from vomstudio.project.journal.database import journal_files, read_replay
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, FeatureType, Model, Record
from vomstudio.project.tables.project_table import ProjectTable, project_table
from vomstudio.registration.summary import summarize_registration

if TYPE_CHECKING:
    from vomstudio.geology.populations.set_statistics import SetStatistics
    from vomstudio.io.text.orientation_reading import OrientationTable
    from vomstudio.project.tables.orientation_table import Row

FORMATS = (".html", ".htm")


@dataclass(frozen=True)
class ProjectReport(Result):
    """Report of a project that was written.

    Parameters
    ----------
    file : str
        Path of the report.
    planes, lines : int
        Number of planes and lines in it.
    quality : dict of str to int
        Number of planes and lines with each verdict.
    skipped : tuple of dict
        Id, name and reason of each feature without an orientation.
    """

    file: str
    planes: int
    lines: int
    quality: dict[str, int]
    skipped: tuple[dict[str, Any], ...]


def report_project(
    folder: Path, path: Path, *, force: bool = False, progress: Progress | None = None
) -> ProjectReport:
    """Write the report of a project on disk, which may be open in a window.

    Raises
    ------
    InputError
        If the folder is not a project.
    UsageError, TargetError
        As `write_project_report`.
    """
    progress = progress or SilentProgress()
    check_extension(path, FORMATS)
    check_target(path, force=force, inputs=journal_files(folder))
    progress.stage(tr("Reading {file}", file=folder.name))
    replay = read_replay(folder)
    progress.stage(tr("Writing {file}", file=path.name))
    measurements = Measurements(get_thresholds(replay.settings))
    return write_project_report(path, replay.records, measurements, title=folder.stem, force=force)


def write_project_report(
    path: Path,
    records: Mapping[str, Record],
    measurements: Measurements,
    *,
    title: str,
    force: bool = False,
) -> ProjectReport:
    """Write the models, features, verdicts and statistics of a project as an HTML file.

    The same project gives the same file.

    Parameters
    ----------
    path : Path
    records : mapping
    measurements : Measurements
    title : str
        Name of the project.
    force : bool, optional
        Whether to replace an existing file.

    Raises
    ------
    UsageError
        If the extension is not that of HTML.
    TargetError
        If the file cannot be written.
    """
    check_extension(path, FORMATS)
    rows = project_table(records, measurements)
    qualities = Counter(row["quality"] for row in rows.rows if row["quality"])
    elements = Counter(row["element"] for row in rows.rows)
    report = ProjectReport(
        str(path), elements["plane"], elements["line"], dict(qualities), tuple(rows.skipped)
    )
    features = [record for record in records.values() if isinstance(record, Feature)]
    body = "".join(
        [
            _summary(records, features, rows, qualities),
            *_models(records, features),
            *_orientations(rows),
            *_statistics(records, features, measurements),
            *_other_features(features, rows, measurements, records),
            paragraph(f"VOM Studio {__version__}", "small"),
        ]
    )
    with atomic_write(path, force) as temporary:
        temporary.write_text(html_page(title, body), encoding="utf-8")
    return report


def _summary(
    records: Mapping[str, Record],
    features: Sequence[Feature],
    rows: ProjectTable,
    qualities: Mapping[str, int],
) -> str:
    models = sum(isinstance(record, Model) for record in records.values())
    counts = [
        tr_n("{count} model", "{count} models", models),
        tr_n("{count} feature", "{count} features", len(features)),
    ]
    text = paragraph(", ".join(counts))
    if qualities:
        verdicts = ", ".join(f"{quality} {n}" for quality, n in sorted(qualities.items()))
        text += paragraph(tr("Quality: {verdicts}", verdicts=verdicts))
    if rows.rows:
        text += paragraph(tr("North: {north}", north=rows.north))
        text += paragraph(rows.limits.description, "small")
    return text


def _models(records: Mapping[str, Record], features: Sequence[Feature]) -> list[str]:
    models = [record for record in records.values() if isinstance(record, Model)]
    if not models:
        return []
    counts = Counter(getattr(feature, "model_id", None) for feature in features)
    head = [tr("model"), tr("kind"), tr("frame"), tr("features"), tr("file")]
    parts = [
        heading(tr("Models")),
        table(
            head,
            [
                (
                    "",
                    [
                        model.name,
                        tr(model.kind),
                        model.frame.name(),
                        f"{counts[model.id]:,}",
                        Path(model.path).name,
                    ],
                )
                for model in models
            ],
        ),
    ]
    registrations = {
        model.registration.id: model.registration for model in models if model.registration
    }
    for registration in registrations.values():
        summary = summarize_registration(registration)
        title = tr("Registration: {name}", name=registration.name)
        parts.append(heading(title, 3))
        if summary.rotation is not None:
            parts.append(paragraph(summary.rotation.message))
        parts.append(table(["", ""], [("", (fact.name, fact.text)) for fact in summary.facts]))
        parts += [paragraph(str(finding), "note") for finding in summary.warnings]
        if registration.control:
            parts.append(
                table(
                    [tr("point"), tr("used as"), tr("east, m"), tr("north, m"), tr("up, m")],
                    [
                        (
                            "",
                            [
                                point.label,
                                tr("check") if point.check else tr("control"),
                                *(number(value, 3) for value in point.residual),
                            ],
                        )
                        for point in registration.control
                    ],
                )
            )
            parts.append(paragraph(tr("Residuals: model minus survey"), "small"))
    return parts


def _orientations(rows: ProjectTable) -> list[str]:
    if not rows.rows:
        return []
    head = [
        tr("name"),
        tr("type"),
        tr("set"),
        tr("orientation"),
        tr("points"),
        tr("extent, m"),
        tr("quality"),
        tr("reasons and notes"),
    ]
    texts = [("out" if row["quality"] == "poor" else "", _cells(row)) for row in rows.rows]
    caption = tr("Planes as dip direction/dip, lines as trend/plunge, with the total 95 % error")
    return [heading(tr("Planes and lines")), table(head, texts), paragraph(caption, "small")]


def _cells(row: Row) -> list[str]:
    error = row["total95_deg"]
    attitude: Plane | Line
    if row["element"] == "plane":
        attitude = Plane(row["dip_direction_deg"] or 0.0, row["dip_deg"])
    else:
        attitude = Line(row["trend_deg"] or 0.0, row["plunge_deg"])
    words = (row["quality_reason"], row["quality_notes"], row["notes"])
    return [
        row["name"],
        row["kind"] or "",
        row["set"] or "",
        # Without a line break before the error.
        format_attitude(attitude, error).replace(" ", "\u00a0"),
        "–" if row["n_points"] is None else f"{row['n_points']:,}",
        number(row["extent_m"], 2),
        row["quality"] or "–",
        " ".join(filter(None, words)),
    ]


def _statistics(
    records: Mapping[str, Record], features: Sequence[Feature], measurements: Measurements
) -> list[str]:
    from vomstudio.geology.populations.statistics_options import StatisticsOptions
    from vomstudio.geology.populations.table_statistics import table_statistics

    measurements_by_id = measurements.of(records, [feature.id for feature in features])
    try:
        orientations = feature_table(records, features, measurements_by_id)
    except InputError:
        return []
    columns = {"kind": tr("type")}
    if any(orientations.column("set")):
        columns["set"] = tr("set")
    tables = []
    for column, title in columns.items():
        statistics = table_statistics(orientations, StatisticsOptions(by=column))
        rows = [("", _figures(name, figures)) for name, figures in statistics.sets.items()]
        tables.append(table([title, "n", tr("mean"), "alpha95", "kappa", "S1, S2, S3"], rows))
    caption = tr(
        "Fisher means with their total 95 % error; S: eigenvalues of the orientation tensor"
    )
    return [
        heading(tr("Statistics")),
        _net(records, orientations),
        *tables,
        paragraph(caption, "small"),
    ]


def _figures(name: str, statistics: SetStatistics) -> list[str]:
    fisher = statistics.fisher
    eigenvalues = ", ".join(f"{value:.3f}" for value in statistics.tensor.eigenvalues)
    if fisher is None:
        reason = "" if statistics.fisher_reason is None else str(statistics.fisher_reason)
        return [name, str(statistics.n), reason, "–", "–", eigenvalues]
    mean: Plane | Line = Line(fisher.trend_deg, fisher.plunge_deg)
    if statistics.of == "poles":
        mean = Plane((fisher.trend_deg + 180.0) % 360.0, 90.0 - fisher.plunge_deg)
    return [
        name,
        str(statistics.n),
        format_attitude(mean, fisher.total95_deg or fisher.alpha95_deg),
        format_error_deg(fisher.alpha95_deg),
        number(fisher.kappa, 1),
        eigenvalues,
    ]


def _net(records: Mapping[str, Record], orientations: OrientationTable) -> str:
    from vomstudio.products.net.figure import write_stereonet
    from vomstudio.products.net.table_net import net_from_table, replace_colors

    types = [record for record in records.values() if isinstance(record, FeatureType)]
    colors = {each.name.casefold(): each.color for each in types}
    picture = BytesIO()
    net = replace_colors(net_from_table(orientations, "kind"), colors)
    write_stereonet(picture, net, format="svg")
    caption = tr("Poles of planes, and lines; equal area, lower hemisphere")
    return svg_picture(picture.getvalue(), caption)


def _other_features(
    features: Sequence[Feature],
    rows: ProjectTable,
    measurements: Measurements,
    records: Mapping[str, Record],
) -> list[str]:
    """List features without an orientation, with reasons for those that should have one."""
    reasons = {item["id"]: str(item["reason"]) for item in rows.skipped}
    names = {row["id"] for row in rows.rows}
    others = [feature for feature in features if feature.id not in names]
    if not others:
        return []
    measurements_by_id = measurements.of(records, [feature.id for feature in others])
    lines = [
        (
            "out" if feature.id in reasons else "",
            [
                feature.name,
                get_kind(feature).noun(feature),
                reasons.get(feature.id)
                or get_kind(feature).headline(measurements_by_id[feature.id])
                or "",
                feature.notes,
            ],
        )
        for feature in others
    ]
    head = [tr("name"), tr("kind"), tr("measurement"), tr("notes")]
    return [heading(tr("Other features")), table(head, lines)]
