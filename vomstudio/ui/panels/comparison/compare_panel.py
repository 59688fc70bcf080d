"""Panel that compares a model with a benchmark by signed distances."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QWidget,
)

from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.options import option_words
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.project.comparisons import (
    StoredComparison,
    distances_file,
    now,
    store_comparison,
    stored_comparisons,
)
from vomstudio.project.records import Model
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import ExportedModel
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.jobs.registration_tasks import (
    COMPARE_MODELS,
    EXPORT_COMPARISON,
    ComparedModels,
    ComparisonExport,
    ComparisonRequest,
)
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import ask_for_target, current_model
from vomstudio.ui.base.controls import ComboBox, Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.comparison.agreement_table import AgreementTable
from vomstudio.ui.panels.comparison.histogram import Histogram, count_distances
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import CopyCommandButton, copy_command
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.other_model_box import OtherModelBox, project_model

DISTANCE_FIELD = "distance_m"
_COLOR_RANGE_PERCENT = 98.0


@dataclass(frozen=True)
class ModelComparison:
    """Compared models, the figures of the command `compare`, and the file of distance fields."""

    model: PlacedModel
    benchmark: PlacedModel
    figures: dict[str, Any]
    fields: Path


class ComparePanel(QWidget):
    """Panel that compares a model with a benchmark.

    Attributes
    ----------
    comparison : ModelComparison or None
        The most recent comparison, or None before the first one.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        set_help_topic(self, "compare.md")
        self._studio = studio
        self.comparison: ModelComparison | None = None
        self._compared_model_id = ""
        self._search_key: tuple[Path, str] | None = None
        self._job: RunningJob | None = None
        self._background = QtBackground(self)
        self._model: Model | None = None
        self.title = hint_label()
        self.other = OtherModelBox(studio, "")
        self.method = ComboBox()
        self.method.setObjectName("compare_method")
        self.method.addItem(tr("Nearest distances"))
        self.method.addItem(tr("M3C2 along normals"))
        self.method.currentIndexChanged.connect(self._show_limits)
        self.limits = OptionFields(CompareOptions, "compare", CompareOptions(m3c2_m=0.5))
        follow_axes(self, studio, lambda axes: self.limits.show_unit(length_unit(axes)))
        self.start = QPushButton(theme.icon("compare-horizontal"), tr("Compare"))
        self.start.clicked.connect(self._start_or_stop)
        self.export = QPushButton(theme.icon("export"), tr("Export PLY…"))
        self.export.clicked.connect(self._ask_for_file)
        self.copy = CopyCommandButton(self._copy_command, tr("the command for this comparison"))
        self.message = hint_label()
        self.figures = Label()
        self.figures.setObjectName("compare_figures")
        self.figures.setTextInteractionFlags(self.message.textInteractionFlags())
        self.histogram = Histogram()
        self.agreement = AgreementTable(studio)
        self._arrange_widgets()
        self.other.model_changed.connect(self._refresh_buttons)
        self.other.status_changed.connect(self.message.setText)
        studio.selection_changed.connect(self.refresh)
        studio.model_loaded.connect(self.refresh)
        connect_until_deleted(self, studio.jobs.closed, self._close)
        studio.edited.connect(self._follow_edit)
        self._show_limits()
        self._show_state()
        self._refresh_buttons()

    def _arrange_widgets(self) -> None:
        form = QFormLayout()
        form.addRow(tr("Benchmark"), self.other)
        form.addRow(tr("Distances"), self.method)
        self._form = form
        self.limits.add_rows(form)
        row = QHBoxLayout()
        row.addWidget(self.start)
        row.addWidget(self.export)
        row.addWidget(self.copy)
        column = narrow_column(self)
        column.addWidget(self.title)
        column.addLayout(form)
        column.addLayout(row)
        column.addWidget(self.message)
        column.addWidget(self.figures)
        column.addWidget(self.histogram)
        column.addWidget(self.agreement)
        column.addStretch()

    # --- models ------------------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """Show the current model and its stored comparison if the panel is visible."""
        if not self.isVisible():
            return
        model = current_model(self._studio) if self._studio.has_project else None
        self._model = model
        self.title.setText(
            Finding("action.no-model").message
            if model is None
            else tr("{model} compared with", model=model.name)
        )
        self.other.list_models_except("" if model is None else model.id)
        self._load_stored_comparison()
        if self._has_model_moved():
            self.message.setText(Finding("comparison.model-moved").message)
        self._refresh_buttons()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        self.agreement.invalidate()
        self.refresh()

    def _follow_edit(self, *_: object) -> None:
        if self.comparison is not None and self._compared_model_id not in self._studio.records:
            self.comparison, self._search_key = None, None
            self.message.setText("")
            self._show_state()
        self.agreement.invalidate()
        self.refresh()

    def _load_stored_comparison(self) -> None:
        """Load the stored comparison of the current model, once per model and project folder."""
        model, studio = self._model, self._studio
        if model is None or self._job is not None or model.id not in studio.models:
            return
        # "Save as" moves the files of a project to the new folder.
        search_key = (studio.project.folder, model.id)
        if self._search_key == search_key or (
            self.comparison is not None and self._compared_model_id == model.id
        ):
            return
        self._search_key = search_key
        record = next(iter(stored_comparisons(*search_key)), None)
        if record is None:
            return
        if not record.is_current(model):
            self.message.setText(
                Finding(
                    "comparison.outdated", benchmark=record.benchmark, day=record.made[:10]
                ).message
            )
            return
        crs = model.frame.crs
        entry = project_model(studio, model)
        if entry is not None:
            crs = entry.to_placed_model(studio.project.cache).crs
        cache = studio.project.cache
        path = studio.project.find_model(model) or Path(record.model_name)
        comparison = ModelComparison(
            PlacedModel(
                name=record.model_name, path=path, cache=cache, to_world=record.to_world, crs=crs
            ),
            PlacedModel(
                name=record.benchmark,
                path=Path(record.benchmark_path),
                cache=cache,
                to_world=record.benchmark_to_world,
                crs=None,
            ),
            dict(record.figures),
            record.fields,
        )
        self.message.setText(tr("Reading the distances of {day}…", day=record.made[:10]))
        self._background.run(
            lambda: _read_stored_comparison(record.fields),
            lambda content: self._show_stored_comparison(model.id, comparison, content),
        )

    def _show_stored_comparison(
        self, model_id: str, comparison: ModelComparison, content: object
    ) -> None:
        """Show a stored comparison.

        Nothing is shown if its file is damaged, another model is current, or a comparison is
        running.
        """
        if content is None or self._model is None or self._model.id != model_id or self._job:
            self.message.setText("")
            return
        self._show_comparison(model_id, comparison, content)

    def _show_limits(self, *_: object) -> None:
        is_m3c2 = self.method.currentIndex() == 1
        for field in self.limits.fields.values():
            self._form.setRowVisible(field, is_m3c2)

    def _refresh_buttons(self, *_: object) -> None:
        is_busy = self._job is not None
        reason = None if is_busy else self._disabled_reason()
        self.start.setText(tr("Stop") if is_busy else tr("Compare"))
        set_enabled(self.start, reason)
        missing_result_finding = (
            None if self.comparison is not None else Finding("action.not-computed")
        )
        if self._model is None:
            missing_result_finding = Finding("action.no-model")
        set_enabled(self.export, Finding("action.busy") if is_busy else missing_result_finding)
        self.copy.set_enabled(self._disabled_reason())
        other_model = self.other.current()
        self.agreement.show_models(
            "" if self._model is None else self._model.id,
            "" if other_model is None else other_model.id,
        )

    def _has_model_moved(self) -> bool:
        """Return whether the model has moved since the comparison."""
        model = self._studio.records.get(self._compared_model_id)
        return (
            self.comparison is not None
            and isinstance(model, Model)
            and model.to_world != self.comparison.model.to_world
        )

    def _disabled_reason(self) -> Finding | None:
        if self._model is None:
            return Finding("action.no-model")
        if self._model.id not in self._studio.models:
            return Finding("model.not-open")
        if self.other.current() is None:
            return Finding("action.no-other-model")
        return None

    # --- command -----------------------------------------------------------------------------
    def _copy_command(self) -> None:
        model, other_model = self._model, self.other.current()
        path = None if model is None else self._studio.project.find_model(model)
        if model is None or path is None or other_model is None:
            return
        options = option_words(self._create_options(model))
        project_option = ("--project", self._studio.project.folder)
        copy_command(self._studio, ["compare", path, other_model.path, project_option, *options])

    def _create_options(self, model: Model) -> CompareOptions:
        """Return the options of the selected method.

        For M3C2, a missing registration error is replaced with that of the model.
        """
        if self.method.currentIndex() != 1:
            return CompareOptions()
        options = self.limits.options()
        if options.registration_error_m is not None:
            return options
        return replace(options, registration_error_m=self._registration_error_m(model))

    # --- job ---------------------------------------------------------------------------------
    def _start_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        studio, model, other_model = self._studio, self._model, self.other.current()
        entry = None if model is None else project_model(studio, model)
        if entry is None or model is None or other_model is None:
            return
        cache = studio.project.cache
        output_path = distances_file(studio.project.folder, new_id("comparison"))
        request = ComparisonRequest(
            entry.to_placed_model(cache),
            other_model.to_placed_model(cache),
            self._create_options(model),
            output_path,
        )
        self.message.setText(tr("Comparing…"))
        self._job = studio.jobs.submit(
            COMPARE_MODELS,
            request,
            title=tr("Comparing {model} with {other}", model=entry.name, other=other_model.name),
            on_done=self._background.guard(
                lambda result: self._store_result(model.id, request, result)
            ),
            on_failed=self._background.guard(self._show_failure),
        )
        self._refresh_buttons()

    def _registration_error_m(self, model: Model) -> float | None:
        loaded_model = self._studio.models.get(model.id)
        if model.registration is None or loaded_model is None:
            return None
        from vomstudio.geometry import transform

        corners = transform.apply(transform.matrix(model.to_world), loaded_model.data.bounds)
        return model.registration.placing_error_m(np.sort(corners, axis=0))

    def _store_result(
        self, model_id: str, request: ComparisonRequest, result: ComparedModels
    ) -> None:
        comparison = ModelComparison(request.model, request.benchmark, result.figures, result.out)
        model = self._studio.records.get(model_id)
        record = (
            None if not isinstance(model, Model) else _comparison_record(model, request, result)
        )

        def read() -> tuple[dict[str, Any], float, Any]:
            if record is not None:
                store_comparison(record)
            # Reading many millions of points takes seconds.
            return _read_comparison(result.out)

        self._background.run(read, lambda read: self._show_comparison(model_id, comparison, read))

    def _show_comparison(self, model_id: str, comparison: ModelComparison, content: object) -> None:
        assert isinstance(content, tuple)
        if model_id not in self._studio.records:
            # The model was removed, or another project opened, in the meantime.
            self._job = None
            self._refresh_buttons()
            return
        fields, limit_m, counts = content
        self._job, self.comparison, self._compared_model_id = None, comparison, model_id
        self._show_state()
        self.histogram.show_counts(counts, limit_m, comparison.figures["median_m"])
        loaded_model = self._studio.models.get(model_id)
        messages = [Finding.from_dict(row).message for row in comparison.figures["warnings"]]
        if loaded_model is not None and loaded_model.add_fields(fields):
            self._studio.display.show_field(model_id, FieldStyle(DISTANCE_FIELD, -limit_m, limit_m))
        else:
            messages.append(Finding("model.fields-too-large").message)
        self.message.setText("\n".join(messages))
        self._refresh_buttons()

    def _show_failure(self, event: Failed) -> None:
        self._job = None
        self.message.setText(str(Finding("job.stopped")) if event.cancelled else event.message)
        self._refresh_buttons()

    def _show_state(self) -> None:
        self.figures.setVisible(self.comparison is not None)
        self.histogram.setVisible(self.comparison is not None)
        if self.comparison is not None:
            self.figures.setText(result_text(self.comparison))

    # --- file --------------------------------------------------------------------------------
    def _ask_for_file(self) -> None:
        if self.comparison is None:
            return
        name = f"{self.comparison.model.path.stem}_distances.ply"
        title = tr("Export the model with its distances")
        path = ask_for_target(self, self._studio, title, name, {"ply": "PLY"})
        if path is not None:
            self.export_distances(path)

    def export_distances(self, path: Path) -> None:
        """Write the compared model, in the World frame, with the distances as scalar fields."""
        if self.comparison is None:
            return
        comparison, studio = self.comparison, self._studio
        # A "Save as" in the meantime has moved the file to the new folder.
        fields = distances_file(studio.project.folder, comparison.fields.stem)

        def handle_result(result: ExportedModel) -> None:
            studio.written(path)
            for finding in result.warnings:
                studio.info(finding)

        def handle_failure(event: Failed) -> None:
            if not event.cancelled:
                studio.warn(event.to_error(), "error")

        studio.jobs.submit(
            EXPORT_COMPARISON,
            ComparisonExport(comparison.model, comparison.benchmark.path, fields, path),
            title=tr("Exporting {file}", file=path.name),
            on_done=handle_result,
            on_failed=handle_failure,
        )

    def _close(self) -> None:
        self._background.stop()
        self.other.cancel_reading()


def _comparison_record(
    model: Model, request: ComparisonRequest, result: ComparedModels
) -> StoredComparison:
    return StoredComparison(
        model_id=model.id,
        model_name=model.name,
        content_hash=model.content_hash,
        to_world=request.model.to_world,
        benchmark=request.benchmark.name,
        benchmark_path=str(request.benchmark.path),
        benchmark_to_world=request.benchmark.to_world,
        radius_m=request.options.m3c2_m,
        figures=result.figures,
        made=now(),
        version=__version__,
        fields=result.out,
    )


def _read_stored_comparison(path: Path) -> tuple[dict[str, Any], float, Any] | None:
    """Read a stored comparison in a worker thread; return None if its file is damaged."""
    try:
        return _read_comparison(path)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _read_comparison(path: Path) -> tuple[dict[str, Any], float, Any]:
    """Read the results of a comparison from a file. Runs in a worker thread.

    Returns
    -------
    dict
        Fields (n,) by name.
    float
        Limit of the colour range in metres.
    Any
        Histogram of the distances, as returned by `count_distances`.

    Raises
    ------
    ValueError
        If a field does not contain one number per point.
    """
    with open_arrays(path) as arrays:
        fields = dict(arrays)
    distances = fields[DISTANCE_FIELD]
    if any(values.ndim != 1 or values.dtype.kind not in "fiu" for values in fields.values()):
        raise ValueError("not the fields of points")
    magnitudes = np.abs(distances[np.isfinite(distances)])
    limit_m = (
        max(float(np.percentile(magnitudes, _COLOR_RANGE_PERCENT)), 1e-9)
        if len(magnitudes)
        else 1.0
    )
    return fields, limit_m, count_distances(distances, limit_m)


def result_text(comparison: ModelComparison) -> str:
    """Format the accuracy, precision and significance as lines of text."""
    figures = comparison.figures

    def format_metres(name: str) -> str:
        value = figures[name]
        return "–" if value is None else f"{value:.3g} m"

    lines = [
        tr("{n:,} distances from {other}", n=figures["n"], other=comparison.benchmark.name),
        tr(
            "Accuracy: mean {mean}, median {median}",
            mean=format_metres("mean_m"),
            median=format_metres("median_m"),
        ),
        tr(
            "Precision: std. deviation {std}, MAD {mad}",
            std=format_metres("std_m"),
            mad=format_metres("mad_m"),
        ),
        tr("Both: RMS {rms}", rms=format_metres("rms_m")),
    ]
    if figures["beyond"]:
        lines.append(tr("{count:,} points have no counterpart", count=figures["beyond"]))
    if figures["lod95_m"] is not None and figures["significant_share"] is not None:
        lines.append(tr("Level of detection (95 %): {lod}", lod=format_metres("lod95_m")))
        significant_percent = 100.0 * figures["significant_share"]
        lines.append(tr("Significant: {share:.1f} % of the distances", share=significant_percent))
    if (side := figures["positive_toward"]) is not None:
        direction = f"{format_azimuth(side['trend_deg'])}/{side['plunge_deg']:02.0f}"
        lines.append(
            tr(
                "Positive: in front of the benchmark, toward {toward} (trend/plunge)",
                toward=direction,
            )
        )
    return "\n".join(lines)
