"""The panel in which a model is held against a benchmark: signed distances, and what of them is
more than chance."""

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
from vomstudio.ui.base.controls import ComboBox, Label, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.comparison.agreement_table import AgreementTable
from vomstudio.ui.panels.comparison.histogram import Histogram, counts_of
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import CopyCommandButton, copy_command
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.other_model_box import OtherModelBox, project_model

FIELD = "distance_m"
_COLORED_PERCENT = 98.0


@dataclass(frozen=True)
class Held:
    """What was compared, and the figures of the command `compare`. fields : the file with them"""

    model: PlacedModel
    benchmark: PlacedModel
    figures: dict[str, Any]
    fields: Path


class ComparePanel(QWidget):
    """held : the last comparison, None while there is none"""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        explain(self, "compare.md")
        self._studio = studio
        self.held: Held | None = None
        self._held_id = ""
        self._sought: tuple[Path, str] | None = None
        self._job: RunningJob | None = None
        self._background = QtBackground(self)
        self._model: Model | None = None
        self.title = hint_label()
        self.other = OtherModelBox(studio, "")
        self.method = ComboBox()
        self.method.setObjectName("compare_method")
        self.method.addItem(tr("Nearest distances"))
        self.method.addItem(tr("M3C2, along the normals"))
        self.method.currentIndexChanged.connect(self._method_chosen)
        self.limits = OptionFields(CompareOptions, "compare", CompareOptions(m3c2_m=0.5))
        follow_axes(studio, lambda axes: self.limits.show_unit(length_unit(axes)))
        self.start = QPushButton(theme.icon("compare-horizontal"), tr("Compare"))
        self.start.clicked.connect(self._start_or_stop)
        self.export = QPushButton(theme.icon("export"), tr("Export PLY…"))
        self.export.clicked.connect(self._ask_for_file)
        self.copy = CopyCommandButton(self._copy_command, tr("the command that compares these two"))
        self.said = hint_label()
        self.figures = Label()
        self.figures.setObjectName("compare_figures")
        self.figures.setTextInteractionFlags(self.said.textInteractionFlags())
        self.histogram = Histogram()
        self.agreement = AgreementTable(studio)
        self._arrange()
        self.other.model_changed.connect(self._refresh_buttons)
        self.other.status_changed.connect(self.said.setText)
        for signal in (studio.project_opened, studio.selection_changed, studio.model_loaded):
            signal.connect(self.refresh)
        studio.jobs.closed.connect(self._close)
        studio.project_opened.connect(self._forget)
        studio.edited.connect(self._edited)
        self._method_chosen()
        self._show()

    def _arrange(self) -> None:
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
        column.addWidget(self.said)
        column.addWidget(self.figures)
        column.addWidget(self.histogram)
        column.addWidget(self.agreement)
        column.addStretch()

    # --- what is there -----------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """Follow the current model, where somebody sees it."""
        if not self.isVisible():
            return
        model = current_model(self._studio) if self._studio.has_project else None
        self._model = model
        self.title.setText(
            Finding("action.no-model").message
            if model is None
            else tr("{model} held against", model=model.name)
        )
        self.other.list_models_except("" if model is None else model.id)
        self._take_up()
        if self._moved_since():
            self.said.setText(Finding("comparison.model-moved").message)
        self._refresh_buttons()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        self.agreement.forget()
        self.refresh()

    def _edited(self, *_: object) -> None:
        self.agreement.forget()
        self.refresh()

    def _take_up(self) -> None:
        """What was kept of the model, once."""
        model, studio = self._model, self._studio
        if model is None or self._job is not None or model.id not in studio.models:
            return
        # A project that was saved elsewhere has its files there.
        place = (studio.project.folder, model.id)
        if self._sought == place or (self.held is not None and self._held_id == model.id):
            return
        self._sought = place
        kept = next(iter(stored_comparisons(*place)), None)
        if kept is None:
            return
        if not kept.is_current(model):
            self.said.setText(
                Finding("comparison.outdated", benchmark=kept.benchmark, day=kept.made[:10]).message
            )
            return
        crs = model.frame.crs
        own = project_model(studio, model)
        if own is not None:
            crs = own.to_placed_model(studio.project.cache).crs
        cache = studio.project.cache
        path = studio.project.find_model(model) or Path(kept.model_name)
        held = Held(
            PlacedModel(kept.model_name, path, cache, kept.to_world, crs),
            PlacedModel(
                kept.benchmark, Path(kept.benchmark_path), cache, kept.benchmark_to_world, None
            ),
            dict(kept.figures),
            kept.fields,
        )
        self.said.setText(tr("Reading the distances of {day}…", day=kept.made[:10]))
        self._background.run(
            lambda: _read_kept(kept.fields), lambda read: self._show_kept(model.id, held, read)
        )

    def _show_kept(self, model_id: str, held: Held, read: object) -> None:
        """Unless another model was chosen meanwhile, or it is being compared again."""
        if read is None or self._model is None or self._model.id != model_id or self._job:
            self.said.setText("")
            return
        self._show_read(model_id, held, read)

    def _forget(self, *_: object) -> None:
        """Another project."""
        self.held, self._sought = None, None
        self.agreement.forget()
        self.said.setText("")
        self._show()

    def _method_chosen(self, *_: object) -> None:
        by_cylinders = self.method.currentIndex() == 1
        for field in self.limits.fields.values():
            self._form.setRowVisible(field, by_cylinders)

    def _refresh_buttons(self, *_: object) -> None:
        busy = self._job is not None
        why = None if busy else self._why_not()
        self.start.setText(tr("Stop") if busy else tr("Compare"))
        allow(self.start, why)
        none = None if self.held is not None else Finding("action.not-computed")
        allow(self.export, Finding("action.busy") if busy else none)
        self.copy.allow(self._why_not())
        other = self.other.current()
        self.agreement.show_models(
            "" if self._model is None else self._model.id, "" if other is None else other.id
        )

    def _moved_since(self) -> bool:
        """Whether the distances are those of another place of the model."""
        now = self._studio.records.get(self._held_id)
        return (
            self.held is not None
            and isinstance(now, Model)
            and now.to_world != self.held.model.to_world
        )

    def _why_not(self) -> Finding | None:
        if self._model is None:
            return Finding("action.no-model")
        if self._model.id not in self._studio.models:
            return Finding("model.not-open")
        if self.other.current() is None:
            return Finding("action.no-other-model")
        return None

    # --- the command -------------------------------------------------------------------------
    def _copy_command(self) -> None:
        model, other = self._model, self.other.current()
        path = None if model is None else self._studio.project.find_model(model)
        if model is None or path is None or other is None:
            return
        options = option_words(self._options(model))
        place = ("--project", self._studio.project.folder)
        copy_command(self._studio, ["compare", path, other.path, place, *options])

    def _options(self, model: Model) -> CompareOptions:
        """Return the options, with the error of the model's registration if none was typed."""
        if self.method.currentIndex() != 1:
            return CompareOptions()
        options = self.limits.options()
        if options.registration_error_m is not None:
            return options
        return replace(options, registration_error_m=self._error_of(model))

    # --- the job -----------------------------------------------------------------------------
    def _start_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        studio, model, other = self._studio, self._model, self.other.current()
        own = None if model is None else project_model(studio, model)
        if own is None or model is None or other is None:
            return
        cache = studio.project.cache
        out = distances_file(studio.project.folder, new_id("comparison"))
        order = ComparisonRequest(
            own.to_placed_model(cache), other.to_placed_model(cache), self._options(model), out
        )
        self.said.setText(tr("Comparing…"))
        self._job = studio.jobs.submit(
            COMPARE_MODELS,
            order,
            title=tr("Comparing {model} with {other}", model=own.name, other=other.name),
            on_done=self._background.guard(lambda made: self._came(model.id, order, made)),
            on_failed=self._background.guard(self._failed),
        )
        self._refresh_buttons()

    def _error_of(self, model: Model) -> float | None:
        opened = self._studio.models.get(model.id)
        if model.registration is None or opened is None:
            return None
        from vomstudio.geometry import transform

        corners = transform.apply(transform.matrix(model.to_world), opened.data.bounds)
        return model.registration.placing_error_m(np.sort(corners, axis=0))

    def _came(self, model_id: str, order: ComparisonRequest, made: ComparedModels) -> None:
        held = Held(order.model, order.benchmark, made.figures, made.out)
        model = self._studio.records.get(model_id)
        kept = None if not isinstance(model, Model) else _as_kept(model, order, made)

        def read() -> tuple[dict[str, Any], float, Any]:
            if kept is not None:
                store_comparison(kept)
            # Seconds, of many millions of points.
            return _read(made.out)

        self._background.run(read, lambda read: self._show_read(model_id, held, read))

    def _show_read(self, model_id: str, held: Held, read: object) -> None:
        assert isinstance(read, tuple)
        fields, reach, counts = read
        self._job, self.held, self._held_id = None, held, model_id
        self._show()
        self.histogram.show_counts(counts, reach, held.figures["median_m"])
        opened = self._studio.models.get(model_id)
        said = [str(each) for each in held.figures["warnings"]]
        if opened is not None and opened.give_fields(fields):
            self._studio.display.show_field(model_id, FieldStyle(FIELD, -reach, reach))
        else:
            said.append(Finding("model.fields-too-large").message)
        self.said.setText("\n".join(said))
        self._refresh_buttons()

    def _failed(self, event: Failed) -> None:
        self._job = None
        self.said.setText(str(Finding("job.stopped")) if event.cancelled else event.message)
        self._refresh_buttons()

    def _show(self) -> None:
        self.figures.setVisible(self.held is not None)
        self.histogram.setVisible(self.held is not None)
        if self.held is not None:
            self.figures.setText(result_text(self.held))

    # --- the file ----------------------------------------------------------------------------
    def _ask_for_file(self) -> None:
        if self.held is None:
            return
        name = f"{self.held.model.path.stem}_distances.ply"
        title = tr("Export the model with its distances")
        path = ask_for_target(self, self._studio, title, name, {"ply": "PLY"})
        if path is not None:
            self.export_to(path)

    def export_to(self, path: Path) -> None:
        """Write the compared model, in World, with its distances as fields."""
        if self.held is None:
            return
        held, studio = self.held, self._studio
        # A project that was saved elsewhere since has taken its files along.
        fields = distances_file(studio.project.folder, held.fields.stem)

        def done(made: ExportedModel) -> None:
            for finding in (Finding("export.written", file=path), *made.warnings):
                studio.info(finding)

        def failed(event: Failed) -> None:
            if not event.cancelled:
                studio.warn(event.to_error(), "error")

        studio.jobs.submit(
            EXPORT_COMPARISON,
            ComparisonExport(held.model, held.benchmark.path, fields, path),
            title=tr("Exporting {file}", file=path.name),
            on_done=done,
            on_failed=failed,
        )

    def _close(self) -> None:
        self._background.stop()
        self.other.close_reading()


def _as_kept(model: Model, order: ComparisonRequest, made: ComparedModels) -> StoredComparison:
    return StoredComparison(
        model.id,
        model.name,
        model.content_hash,
        order.model.to_world,
        order.benchmark.name,
        str(order.benchmark.path),
        order.benchmark.to_world,
        order.options.m3c2_m,
        made.figures,
        now(),
        __version__,
        made.out,
    )


def _read_kept(path: Path) -> tuple[dict[str, Any], float, Any] | None:
    """In a thread; None for a file that cannot be read."""
    try:
        return _read(path)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _read(path: Path) -> tuple[dict[str, Any], float, Any]:
    """In a thread: the fields, how far from zero the colours reach (m), and the histogram."""
    with open_arrays(path) as arrays:
        fields = dict(arrays)
    distances = fields[FIELD]
    if any(values.ndim != 1 or values.dtype.kind not in "fiu" for values in fields.values()):
        raise ValueError("not the fields of points")
    left = np.abs(distances[np.isfinite(distances)])
    reach = max(float(np.percentile(left, _COLORED_PERCENT)), 1e-9) if len(left) else 1.0
    return fields, reach, counts_of(distances, reach)


def result_text(comparison: Held) -> str:
    """Accuracy, precision, and what is more than chance, in lines."""
    told = comparison.figures

    def metres(name: str) -> str:
        value = told[name]
        return "–" if value is None else f"{value:.3g} m"

    said = [
        tr("{n:,} distances from {other}", n=told["n"], other=comparison.benchmark.name),
        tr(
            "Accuracy: mean {mean}, median {median}",
            mean=metres("mean_m"),
            median=metres("median_m"),
        ),
        tr("Precision: std. deviation {std}, MAD {mad}", std=metres("std_m"), mad=metres("mad_m")),
        tr("Both: RMS {rms}", rms=metres("rms_m")),
    ]
    if told["beyond"]:
        said.append(tr("{count:,} points have no counterpart", count=told["beyond"]))
    if told["lod95_m"] is not None and told["significant_share"] is not None:
        said.append(tr("Level of detection (95 %): {lod}", lod=metres("lod95_m")))
        share = 100.0 * told["significant_share"]
        said.append(tr("Significant: {share:.1f} % of the distances", share=share))
    if (side := told["positive_toward"]) is not None:
        toward = f"{format_azimuth(side['trend_deg'])}/{side['plunge_deg']:02.0f}"
        said.append(
            tr("Positive: before the benchmark, toward {toward} (trend/plunge)", toward=toward)
        )
    return "\n".join(said)
