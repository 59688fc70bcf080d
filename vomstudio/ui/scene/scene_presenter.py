"""Records as the viewport draws them, and the viewport's clicks as selection."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np
import numpy.typing as npt

from vomstudio.document.edit import Edit
from vomstudio.document.measurements import Measurement
from vomstudio.document.records import (
    FEATURES,
    IDENTITY,
    Dimension,
    Feature,
    FeatureType,
    Intersection,
    Lineation,
    Model,
    Patch,
    Trace,
)
from vomstudio.geology.orientation import slip_from_rake
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.discs import disc
from vomstudio.geometry.patches import has_id
from vomstudio.geometry.planes import PlaneFit
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import PREVIEW, FeatureDrawing, Symbol
from vomstudio.rendering.view.scalars import field_names
from vomstudio.rendering.view.symbols import small_disc, symbol_of_line, symbol_of_plane
from vomstudio.tools.patch import area_of
from vomstudio.tools.types import Area, Button, Pointer, PointerEvent, Preview
from vomstudio.ui.common.studio import DIMENSIONS, Studio, group_of
from vomstudio.ui.common.wording import drawn_points, length, orientation_text
from vomstudio.ui.scene.first_view import first_view

NOTHING_KNOWN_DEG = 45.0


class ScenePresenter:
    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        self._studio = studio
        self._viewport = viewport
        self._models, self._moves, self._drawn = viewport.models, viewport.moves, viewport.features
        self._shown: set[str] = set()
        self._features: set[str] = set()
        self._placed = False
        self._areas: dict[str, tuple[Patch, Model, Area | None]] = {}
        studio.project_opened.connect(self.rebuild)
        studio.edited.connect(self._edited)
        studio.model_loaded.connect(self._model_loaded)
        studio.visibility_changed.connect(self._visibility)
        studio.selection_changed.connect(viewport.features.select)
        studio.preview.connect(self._preview)
        studio.settings_changed.connect(self._all_features)
        studio.display.changed.connect(self._displayed)
        viewport.clip_changed.connect(studio.display.set_clip)
        self._stages: dict[str, set[str]] = {}
        self._previews: set[str] = set()
        self._spent_previews: set[str] = set()
        studio.loader.previewed.connect(self._show_preview)
        studio.loader.ended.connect(self._end_preview)
        viewport.model_stage.connect(self._stage)
        viewport.pointer.connect(self._pointer)

    def rebuild(self) -> None:
        for model_id in self._shown:
            self._models.remove(model_id)
        self._shown.clear()
        self._drawn.change(dict.fromkeys(self._features))
        self._features.clear()
        self._areas.clear()
        self._placed = self._take_camera()
        for what in ("mode", "lit", "point_size", "eye_dome", "clip"):
            self._displayed(what)
        for model_id in self._studio.models:
            self._model_loaded(model_id)
        self._all_features()
        self._frame()

    def _take_camera(self) -> bool:
        """Look at an opened project as it was last looked at; its features stand there even while
        its model is read or missing."""
        camera = self._studio.project.journal.view("camera")
        try:
            if camera is not None:
                self._moves.set_camera_state(camera)
                return True
        except (ValueError, KeyError, TypeError):
            pass
        measured = self._studio.measured(f.id for f in self._studio.session.features())
        points = [p for m in measured.values() if len(p := drawn_points(m))]
        if points:
            self._moves.frame(np.concatenate(points))
        return False

    # --- models ------------------------------------------------------------------------------
    def _model_loaded(self, model_id: str) -> None:
        record = self._studio.records.get(model_id)
        opened = self._studio.models.get(model_id)
        if not isinstance(record, Model) or opened is None or model_id in self._shown:
            return
        first = not self._shown and not self._placed
        if first:
            self._face(model_id)
        self._stages.pop(model_id, None)
        self._models.add(
            model_id, opened.data, transform.matrix(record.to_world), frame_camera=first
        )
        self._models.set_visible(model_id, self._model_visible(model_id))
        self._shown.add(model_id)
        self._show_field(model_id)
        self._frame()
        self._draw(p.id for p in self._studio.session.of(Patch) if p.model_id == model_id)

    # --- display -----------------------------------------------------------------------------
    def _displayed(self, what: str) -> None:
        shown, viewport = self._studio.display, self._viewport
        if what == "mode":
            viewport.display.set_mode(shown.mode)
        elif what == "lit":
            for mode, lit in shown.lit.items():
                viewport.display.set_lit(mode, lit)
        elif what == "point_size":
            viewport.display.set_point_size(shown.point_size)
        elif what == "eye_dome":
            viewport.display.set_eye_dome(shown.eye_dome)
        elif what in ("clip", "box"):
            viewport.clip.set_box(shown.clip_shown, handles=shown.handles)
        elif what == "fields":
            for model_id in self._shown:
                self._show_field(model_id)

    def _show_field(self, model_id: str) -> None:
        style, opened = self._studio.display.styles.get(model_id), self._studio.models[model_id]
        if style is not None and style.name not in field_names(opened.data):
            # The file has changed since the field was chosen.
            style = None
        self._viewport.display.set_field(model_id, style, self._studio.records[model_id].name)

    def models_box(self) -> ClipBox | None:
        """Around all visible models."""
        ids = [i for i in self._shown if self._model_visible(i) and i in self._studio.models]
        if not ids:
            return None
        return ClipBox.around(np.concatenate([self._corners(i) for i in ids]))

    # --- what stands for a cloud while it is read --------------------------------------------
    def _show_preview(self, key: str, cloud: PointCloud) -> None:
        record = self._studio.records.get(key)
        frame = record.to_world if isinstance(record, Model) else IDENTITY
        to_world = transform.matrix(frame)
        first = not self._shown and not self._placed
        if first:
            self._moves.look_along(*first_view(cloud, to_world))
            # From here on the view is the user's.
            self._placed = True
        self._models.add(PREVIEW + key, cloud, to_world, frame_camera=first)
        self._previews.add(key)

    def _end_preview(self, key: str) -> None:
        """The cloud is there, or never will be: in the first case it still has to be drawn."""
        if key not in self._previews:
            return
        self._previews.discard(key)
        self._spent_previews.add(key)
        if all("shown" in self._stages.get(i, set()) for i in self._shown):
            self._drop_previews()

    def _stage(self, model_id: str, stage: str) -> None:
        self._stages.setdefault(model_id, set()).add(stage)
        if model_id in self._shown and stage == "shown":
            self._drop_previews()

    def _drop_previews(self) -> None:
        for key in self._spent_previews:
            self._models.remove(PREVIEW + key)
        self._spent_previews.clear()

    def see_all(self, besides: npt.NDArray[np.float64] | None = None) -> None:
        """All visible models, from the exposed side of the first, and the World points `besides`
        (n, 3)."""
        ids = [m.id for m in self._studio.session.of(Model) if self._model_visible(m.id)]
        ids = [i for i in ids if i in self._studio.models]
        if not ids:
            self._moves.home()
            return
        self._face(ids[0])
        more = [] if besides is None else [besides]
        self._moves.frame(np.concatenate([*(self._corners(i) for i in ids), *more]))

    def _face(self, model_id: str) -> None:
        model = self._studio.records[model_id]
        assert isinstance(model, Model)
        self._moves.look_along(
            *first_view(self._studio.models[model_id].data, transform.matrix(model.to_world))
        )

    def _corners(self, model_id: str) -> npt.NDArray[np.float64]:
        """(8, 3) corners of a model's box, in World."""
        model = self._studio.records[model_id]
        assert isinstance(model, Model)
        bounds = self._studio.models[model_id].data.bounds
        return transform.apply(model.to_world, np.array(list(product(*bounds.T))))

    def _find_far(self, model_id: str) -> None:
        """A model that is opened far from the others would be looked for in vain."""
        others = [i for i in self._shown if i != model_id and i in self._studio.models]
        if model_id not in self._shown or not others:
            return
        own, there = self._corners(model_id), np.concatenate([self._corners(i) for i in others])
        gap = max(
            float((own.min(axis=0) - there.max(axis=0)).max()),
            float((there.min(axis=0) - own.max(axis=0)).max()),
        )
        if gap > max(float(np.ptp(own, axis=0).max()), float(np.ptp(there, axis=0).max())):
            self._face(model_id)
            self._moves.frame(own)
            self._studio.warn(
                f"{self._studio.records[model_id].name} lies {length(gap)} from the other models: "
                "is its frame right? Whole model (Home) shows all of them."
            )

    def _model_visible(self, model_id: str) -> bool:
        return self._studio.visible(model_id) and self._studio.visible("models")

    def _frame(self) -> None:
        self._viewport.set_frame(
            north_known=self._studio.north_known(), unit_known=self._studio.metres_known()
        )

    # --- features ----------------------------------------------------------------------------
    def _edited(self, edit: Edit) -> None:
        for id_, record in edit.after.items():
            if isinstance(edit.before[id_], Model) and record is None:
                self._models.remove(id_)
                self._shown.discard(id_)
            elif isinstance(record, Model):
                if id_ in self._shown:
                    self._models.set_to_world(id_, transform.matrix(record.to_world))
                    before = edit.before[id_]
                    if isinstance(before, Model) and before.to_world != record.to_world:
                        # Another unit or axis takes the model out of sight.
                        self.see_all()
                    self._frame()
                else:
                    self._model_loaded(id_)
                    self._find_far(id_)
        self._draw(self._studio.affected(edit))

    def _all_features(self) -> None:
        self._draw(feature.id for feature in self._studio.session.features())

    def _draw(self, ids: Iterable[str]) -> None:
        ids = list(ids)
        measured = self._studio.measured(ids)
        changes: dict[str, FeatureDrawing | None] = {}
        for id_ in ids:
            feature = self._studio.records.get(id_)
            drawing = (
                self._drawing(feature, measured[id_]) if isinstance(feature, FEATURES) else None
            )
            changes[id_] = drawing
            if drawing is None:
                self._features.discard(id_)
                self._areas.pop(id_, None)
            else:
                self._features.add(id_)
        if changes:
            self._drawn.change(changes)

    def _drawing(self, feature: Feature, measured: Measurement) -> FeatureDrawing | None:
        """None where the feature has no place in the outcrop."""
        area = self._area(feature) if isinstance(feature, Patch) else None
        line = self._line(feature, measured) if area is None else np.zeros((0, 3))
        if not len(line) and area is None:
            return None
        group = group_of(feature)
        kind = self._studio.records.get(group)
        fit = measured.fit
        text = orientation_text(measured, self._studio.settings.notation)
        planes_as = self._studio.settings.planes_as
        extent = extent_of(measured)
        ring, symbol = None, None
        if planes_as == "symbols":
            symbol = symbol_of(feature, measured, extent)
            if symbol is not None:
                # Its number stands beside the symbol.
                text = "–"
        elif (
            planes_as == "discs"
            and fit is not None
            and fit.extent is not None
            and area is None
            and known_well_enough(fit)
        ):
            ring = disc(fit.centroid, fit.normal, 0.5 * fit.extent)
            symbol = small_disc(fit.centroid, fit.extent)
        return FeatureDrawing(
            id=feature.id,
            line=line,
            disc=ring,
            color=_rgb(kind.color if isinstance(kind, FeatureType) else "#ffffff"),
            label=feature.name if text == "–" else f"{feature.name}  {text}",
            anchor=middle_of(feature, measured, line) if area is None else _middle(area),
            visible=self._studio.visible(feature.id) and self._studio.visible(group),
            area=area,
            symbol=symbol,
            extent=extent,
        )

    def _area(self, patch: Patch) -> Area | None:
        """The painted piece of an open model, made once."""
        model, opened = (
            self._studio.records.get(patch.model_id),
            self._studio.models.get(patch.model_id),
        )
        if opened is None or not isinstance(model, Model):
            return None
        kept = self._areas.get(patch.id)
        if kept is None or kept[0].runs is not patch.runs or kept[1].to_world != model.to_world:
            kept = (patch, model, area_of(patch, model, opened.surface))
            self._areas[patch.id] = kept
        return kept[2]

    def _patch_at(self, x: float, y: float) -> str | None:
        """The smallest visible patch that has the face or point under a pixel."""
        hit = self._viewport.pick(x, y)
        if hit is None:
            return None
        found = [
            (patch.n, patch.id)
            for patch in self._studio.session.of(Patch)
            if patch.model_id == hit.model_id
            and patch.element == hit.element
            and has_id(patch.runs, hit.index)
            and self._studio.visible(patch.id)
            and self._studio.visible(patch.type_id)
        ]
        return min(found)[1] if found else None

    def _line(self, feature: Feature, measured: Measurement) -> npt.NDArray[np.float64]:
        points = measured.points
        if isinstance(feature, Patch) and len(feature.outline) > 2:
            model = self._studio.records.get(feature.model_id)
            rows = model.to_world if isinstance(model, Model) else IDENTITY
            return transform.apply(rows, (*feature.outline, feature.outline[0]))
        if isinstance(feature, Dimension) and feature.kind == "area" and len(points) > 2:
            return np.vstack([points, points[:1]])
        if isinstance(feature, Lineation) and measured.slip_rake_deg is not None:
            return self._with_arrow(feature, measured)
        return points

    def _with_arrow(self, feature: Lineation, measured: Measurement) -> npt.NDArray[np.float64]:
        """The line with a head at the end toward which the hanging wall moved."""
        plane = self._studio.measured([feature.plane_id])[feature.plane_id].plane
        if plane is None or measured.slip_rake_deg is None:
            return measured.points
        ends = measured.points
        slip = slip_from_rake(plane, measured.slip_rake_deg).vector()
        if (ends[-1] - ends[0]) @ slip < 0.0:
            ends = ends[::-1]
        size = 0.18 * float(np.linalg.norm(ends[-1] - ends[0]))
        across = np.cross(plane.normal(), slip)
        wings = [ends[-1] + size * (0.5 * side * across - slip) for side in (1.0, -1.0)]
        return np.vstack([ends, wings[0], ends[-1], wings[1]])

    def _visibility(self, ids: tuple[str, ...]) -> None:
        for model_id in self._shown:
            self._models.set_visible(model_id, self._model_visible(model_id))
        if DIMENSIONS in ids or any(
            isinstance(self._studio.records.get(i), FeatureType) for i in ids
        ):
            self._all_features()
        else:
            self._draw(i for i in ids if isinstance(self._studio.records.get(i), FEATURES))

    # --- tool and pointer --------------------------------------------------------------------
    def _preview(self, preview: Preview | None) -> None:
        self._viewport.set_preview(preview)

    def _pointer(self, event: PointerEvent) -> None:
        if self._studio.tool_name != "navigate":
            self._studio.pointer(event)
        elif event.kind is Pointer.CLICK and event.button is Button.LEFT:
            found = (
                self._drawn.at(event.x, event.y, discs=False)
                or self._patch_at(event.x, event.y)
                or self._drawn.at(event.x, event.y)
            )
            if found is not None and event.ctrl:
                self._studio.selection.toggle(found)
            elif not event.ctrl:
                self._studio.selection.set([] if found is None else [found])


def _middle(area: Area) -> npt.NDArray[np.float64]:
    """A point of the surface in the middle of an area."""
    points = area.corners.reshape(-1, 3)
    off = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    return area.origin + points[int(off.argmin())]


def known_well_enough(fit: PlaneFit) -> bool:
    """Whether a disc says something: one that may as well stand across does not."""
    return fit.max_confidence95_deg is None or fit.max_confidence95_deg < NOTHING_KNOWN_DEG


def extent_of(measured: Measurement) -> float:
    """m, how far a feature reaches: its longest axis or the size of its box; 0 for a point."""
    if measured.fit is not None and measured.fit.extent is not None:
        return float(measured.fit.extent)
    if not len(measured.points):
        return 0.0
    return float(np.linalg.norm(np.ptp(measured.points, axis=0)))


def middle_of(
    feature: Feature, measured: Measurement, line: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """(3,) where a feature is named: on the rock, so of a trace the vertex nearest its centroid,
    which itself may lie in the air or inside; half way along what has two ends."""
    if isinstance(feature, Lineation | Dimension | Intersection) and len(line) > 1:
        if isinstance(feature, Lineation):
            line = line[: len(feature.vertices)]
        lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(lengths)])
        return np.array([np.interp(0.5 * along[-1], along, line[:, i]) for i in range(3)])
    points = measured.points if len(measured.points) else line
    centre = points.mean(axis=0) if measured.fit is None else measured.fit.centroid
    if isinstance(feature, Trace):
        centre = points[int(np.argmin(np.linalg.norm(points - centre, axis=1)))]
    return np.asarray(centre, float)


def symbol_of(feature: Feature, measured: Measurement, extent: float) -> Symbol | None:
    """Strike and dip, or trend and plunge, at the middle of a feature that has one."""
    if isinstance(feature, Dimension) or not len(measured.points):
        return None
    place = middle_of(feature, measured, measured.points)
    if measured.plane is not None:
        plane = measured.plane
        return symbol_of_plane(
            plane.dip_direction_deg,
            plane.dip_deg,
            place,
            extent,
            overturned=bool(getattr(feature, "overturned", False)),
        )
    if measured.line is not None:
        return symbol_of_line(measured.line.trend_deg, measured.line.plunge_deg, place, extent)
    return None


def _rgb(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue
