"""Prediction of the positions of control, check and tie points in photos.

The module also computes the residuals of marks, and reports what a registration still needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry.cameras import View
from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.photos.cameras_file import FILE_NAME, Cameras, read_cameras
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.registration.marks.mark_errors import Marks, mark_distances
from vomstudio.registration.marks.wrong_marks import find_consistent_marks
from vomstudio.registration.similarity import Similarity, fit_robustly, is_nearly_collinear

Pixel = tuple[float, float]

MIN_POINTS, MIN_PHOTOS = 3, 2
MAX_GOOD_RESIDUAL_PX = 2.0
"""Marks with larger residuals are highlighted."""
_MIN_MARKS_TO_SUSPECT = 4
CONTROL, CHECK, TIE = "control", "check", "tie"


@dataclass(frozen=True)
class ControlMarks:
    """Points and their marks.

    Attributes
    ----------
    control : tuple of ControlPoint
        Control and check points, which have coordinates.
    marks : tuple of Mark
        Marks of these points; marks with other labels belong to tie points.
    new_labels : tuple of str
        Labels that have neither coordinates nor marks yet.
    """

    control: tuple[ControlPoint, ...] = ()
    marks: tuple[Mark, ...] = ()
    new_labels: tuple[str, ...] = ()

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Labels of points with coordinates in table order, then others as created."""
        control_labels = [p.label for p in self.control]
        other_labels = [*(m.label for m in self.marks), *self.new_labels]
        return tuple(dict.fromkeys([*control_labels, *other_labels]))

    def point(self, label: str) -> ControlPoint | None:
        """Return the control or check point with this label, or None if it has no coordinates."""
        return next((p for p in self.control if p.label == label), None)

    def role(self, label: str) -> str:
        """Return the role of a point: CONTROL, CHECK or TIE."""
        point = self.point(label)
        return TIE if point is None else CHECK if point.check else CONTROL

    def of(self, label: str) -> dict[str, Pixel]:
        """Return the marks of a point, keyed by photo."""
        return {m.photo: (m.x, m.y) for m in self.marks if m.label == label}

    def marks_in_photo(self, photo: str) -> dict[str, Pixel]:
        """Return the marks in a photo, keyed by point."""
        return {m.label: (m.x, m.y) for m in self.marks if m.photo == photo}

    def free_label(self, prefix: str = "tie") -> str:
        """Return the first unused label: prefix1, prefix2 and so on."""
        number = 1
        while f"{prefix}{number}" in self.labels:
            number += 1
        return f"{prefix}{number}"

    # --- changed ------------------------------------------------------------------------------
    def set_mark(self, label: str, photo: str, pixel: Pixel) -> ControlMarks:
        """Return a copy in which a point is marked in a photo."""
        mark = Mark(label, photo, float(pixel[0]), float(pixel[1]))
        rows = [i for i, m in enumerate(self.marks) if (m.label, m.photo) == (label, photo)]
        marks = list(self.marks)
        if rows:
            marks[rows[0]] = mark
        else:
            marks.append(mark)
        return replace(self, marks=tuple(marks), new_labels=_remove_label(self.new_labels, label))

    def remove_mark(self, label: str, photo: str) -> ControlMarks:
        """Return a copy without the mark of a point in a photo; the point remains."""
        marks = tuple(m for m in self.marks if (m.label, m.photo) != (label, photo))
        unmarked_labels = self.new_labels if label in self.new_labels else (*self.new_labels, label)
        return replace(self, marks=marks, new_labels=unmarked_labels)

    def add_label(self, label: str) -> ControlMarks:
        """Return a copy with a new label that has neither coordinates nor marks yet."""
        return self if label in self.labels else replace(self, new_labels=(*self.new_labels, label))

    def set_coordinates(self, point: ControlPoint) -> ControlMarks:
        """Return a copy in which a point has new coordinates."""
        points = tuple(point if p.label == point.label else p for p in self.control)
        if point not in points:
            points = (*points, point)
        return replace(self, control=points, new_labels=_remove_label(self.new_labels, point.label))

    def remove_coordinates(self, label: str) -> ControlMarks:
        """Return a copy in which a point has no coordinates and is therefore a tie point."""
        control = tuple(p for p in self.control if p.label != label)
        unmarked_labels = self.new_labels if label in self.new_labels else (*self.new_labels, label)
        return replace(self, control=control, new_labels=unmarked_labels)

    def remove_point(self, label: str) -> ControlMarks:
        """Return a copy without a point and its marks."""
        return ControlMarks(
            tuple(p for p in self.control if p.label != label),
            tuple(m for m in self.marks if m.label != label),
            _remove_label(self.new_labels, label),
        )

    def rename_point(self, old_label: str, new_label: str) -> ControlMarks:
        """Return a copy in which a point is renamed.

        Raises GeometryError if the new label is already used or invalid.
        """
        if new_label == old_label:
            return self
        check_label(new_label)
        if new_label in self.labels:
            raise GeometryError(Finding("label.in-use", label=new_label))
        return ControlMarks(
            tuple(replace(p, label=new_label) if p.label == old_label else p for p in self.control),
            tuple(replace(m, label=new_label) if m.label == old_label else m for m in self.marks),
            tuple(new_label if label == old_label else label for label in self.new_labels),
        )

    def add_marks(
        self, marks: Iterable[Mark], photos: Sequence[str]
    ) -> tuple[ControlMarks, list[str]]:
        """Add marks, replacing existing ones of the same point and photo.

        Returns a copy with the marks, and the names of unknown photos, whose marks are also added.
        """
        find_mark, marking, unknown_photos = photo_finder(photos), self, []
        for mark in marks:
            number = find_mark(mark.photo)
            if number is None:
                unknown_photos.append(mark.photo)
            name = mark.photo if number is None else photos[number]
            marking = marking.set_mark(mark.label, name, (mark.x, mark.y))
        return marking, list(dict.fromkeys(unknown_photos))


def check_label(label: str) -> None:
    """Raise GeometryError if a label is invalid."""
    if not label or label != label.strip() or not label.isprintable():
        raise GeometryError(Finding("label.invalid"))


def _remove_label(labels: tuple[str, ...], label: str) -> tuple[str, ...]:
    return tuple(item for item in labels if item != label)


# --- with cameras ---------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class MarkPrediction:
    """Predicted positions of a point in photos, and residuals of its marks.

    Attributes
    ----------
    expected : dict
        Predicted pixel in each photo that shows the point but in which it is not marked.
    residuals_px : dict
        Distance of each mark from the position determined by all marks of its component, if it has
        at least two.
    pixel : dict
        Size of a pixel at the point, in units of the component, in each photo of `expected` and
        `residuals_px`.
    suspect : str or None
        Photo of the mark whose removal makes the remaining marks fit best. None if all marks fit,
        or if there are too few.
    """

    expected: dict[str, Pixel]
    residuals_px: dict[str, float]
    pixel: dict[str, float]
    suspect: str | None = None

    @property
    def worst_mark(self) -> tuple[str, float] | None:
        """Photo and residual of the suspect mark or of the one with the largest residual.

        None if the marks have no residuals.
        """
        if not self.residuals_px:
            return None
        name = self.suspect or max(self.residuals_px, key=self.residuals_px.__getitem__)
        return name, self.residuals_px[name]

    @property
    def unmarked_photos(self) -> list[str]:
        """Photos in which the point is not marked, the closest first."""
        return sorted(self.expected, key=lambda name: self.pixel[name])


NO_PREDICTION = MarkPrediction({}, {}, {})


@dataclass(frozen=True, eq=False)
class PlacedPhotos:
    """Cameras of all connected components of the photos, that of the model first."""

    parts: tuple[Cameras, ...]

    @classmethod
    def read(cls, out: Path) -> PlacedPhotos:
        """Read the cameras from the folder of a reconstruction.

        Raises InputError if a file cannot be read.
        """
        parts = [read_cameras(out / FILE_NAME)]
        number = 2
        while (path := out / f"part{number}" / FILE_NAME).exists():
            parts.append(read_cameras(path))
            number += 1
        return cls(tuple(parts))

    def component_number(self, photo: str) -> int | None:
        """Return the number of the component that contains a photo, or None if it has no pose."""
        for number, views in enumerate(self._views):
            if photo in views:
                return number
        return None

    @cached_property
    def _views(self) -> tuple[dict[str, View], ...]:
        return tuple({view.name: view for view in part.views} for part in self.parts)

    def predict(self, marking: ControlMarks, label: str) -> MarkPrediction:
        """Predict the position of a point in all photos with a pose, and compute its residuals."""
        marks = marking.of(label)
        expected_pixels: dict[str, Pixel] = {}
        residuals: dict[str, float] = {}
        sizes: dict[str, float] = {}
        suspect_mark = None
        for number, views in enumerate(self._views):
            part_marks = self._marks(number, marks)
            place = self._place(part_marks)
            if place is not None:
                distances = mark_distances(part_marks, place[0])
                names = [view.name for view in part_marks.views]
                residuals |= dict(zip(names, distances.tolist(), strict=True))
                wrong_marks = find_consistent_marks(label, part_marks, MAX_GOOD_RESIDUAL_PX)[1]
                if (
                    len(distances) >= _MIN_MARKS_TO_SUSPECT
                    and wrong_marks
                    and distances.max() == max(residuals.values())
                ):
                    suspect_mark = max(wrong_marks, key=lambda mark: residuals[mark.photo]).photo
            else:
                place = self._place_by_coordinates(marking, label, number)
            if place is None:
                continue
            for name, view in views.items():
                (pixel,) = view.project(place)
                if not np.isfinite(pixel).all() or not view.contains(pixel)[0]:
                    continue
                sizes[name] = float(view.depths(place)[0] / np.mean(view.intrinsics.focal))
                if name not in marks:
                    expected_pixels[name] = (float(pixel[0]), float(pixel[1]))
        return MarkPrediction(expected_pixels, residuals, sizes, suspect_mark)

    def epipolar_line(self, marking: ControlMarks, label: str, photo: str) -> FloatArray:
        """Return the epipolar line (k, 2), in pixels, of a point marked in one other photo.

        The result is empty if the point is marked in `photo` itself, if `photo` has no pose, or if
        not exactly one other photo of its component contains a mark.
        """
        number = self.component_number(photo)
        if number is None or photo in marking.of(label):
            return np.zeros((0, 2))
        views = self._views[number]
        marks_in_views = [
            (views[name], pixel) for name, pixel in marking.of(label).items() if name in views
        ]
        if len(marks_in_views) != 1:
            return np.zeros((0, 2))
        (view, pixel), other_view = marks_in_views[0], views[photo]
        baseline = float(np.linalg.norm(other_view.centre - view.centre))
        # Steps must be small near the camera; far away, the pixel changes very little.
        distances = np.geomspace(0.05, 2000.0, 600)[:, None] * baseline
        pixels = other_view.project(view.centre + distances * view.rays(pixel))
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        return pixels[other_view.contains(pixels)]

    def _marks(self, number: int, marks: Mapping[str, Pixel]) -> Marks:
        """Return the marks of a point in the photos of a part."""
        views = self._views[number]
        names = [name for name in marks if name in views]
        pixels = np.array([marks[name] for name in names], np.float64).reshape(-1, 2)
        return Marks([views[name] for name in names], pixels)

    @staticmethod
    def _place(marks: Marks) -> FloatArray | None:
        """Return the position (1, 3) in the frame of the component, or None if undetermined."""
        place = triangulate(*marks)
        return place[None] if np.isfinite(place).all() else None

    def _place_by_coordinates(
        self, marking: ControlMarks, label: str, number: int
    ) -> FloatArray | None:
        """Return the position (1, 3) in a component of a point that has coordinates.

        Returns None if the point has no coordinates or the component has no known frame.
        """
        point = marking.point(label)
        if point is None:
            return None
        part = self.parts[number]
        if (frame := self._fit_frame(marking, number)) is not None:
            return frame(point.position)
        if part.crs is None and not part.is_scaled:
            return None
        return (np.array(point.position) - part.origin)[None]

    def _fit_frame(self, marking: ControlMarks, number: int) -> Similarity | None:
        """Return the similarity from the World frame to a component, from its marked points.

        Returns None if these points are too few or do not determine it.
        """
        known_positions, positions = [], []
        for point in marking.control:
            place = self._place(self._marks(number, marking.of(point.label)))
            if place is not None:
                known_positions.append(point.position)
                positions.append(place[0])
        if len(known_positions) < MIN_POINTS:
            return None
        try:
            return fit_robustly(np.array(known_positions), np.array(positions))[0]
        except GeometryError:
            return None


# --- tables ---------------------------------------------------------------------------------------
def usable_tables(
    control: Path | None, marks: Path | None, photos: Sequence[str]
) -> tuple[Path | None, Path | None, list[Finding]]:
    """Return the tables beside the photos that can be used to register a model.

    If the marks of the control points are not sufficient, the table of control points is omitted
    and the reasons are returned. Raises InputError if a table cannot be read.
    """
    if control is None or marks is None:
        return None, marks, []
    find_mark = photo_finder(photos)
    rows = [(mark, find_mark(mark.photo)) for mark in read_marks(marks)]
    usable_marks = tuple(replace(mark, photo=photos[row]) for mark, row in rows if row is not None)
    marking = ControlMarks(tuple(read_control(control)), usable_marks)
    usable_labels = find_usable_points(marking)
    if len(usable_labels) < MIN_POINTS or _is_collinear(marking, usable_labels):
        return None, marks, missing_marks_findings(marking)
    return control, marks, []


# --- what is missing ------------------------------------------------------------------------------
def find_usable_points(marking: ControlMarks, photos: Iterable[str] | None = None) -> list[str]:
    """Return the labels of the control points marked in enough photos to place the model."""
    allowed_photos = None if photos is None else set(photos)
    return [
        p.label
        for p in marking.control
        if not p.check and len(_marked_photos(marking, p.label, allowed_photos)) >= MIN_PHOTOS
    ]


def missing_marks_findings(
    marking: ControlMarks, placed_photos: PlacedPhotos | None = None
) -> list[Finding]:
    """Report what is still needed to register by control points and to join components."""
    findings = []
    allowed_photos = (
        None if placed_photos is None else {v.name for v in placed_photos.parts[0].views}
    )
    control = [p.label for p in marking.control if not p.check]
    usable_labels = find_usable_points(marking, allowed_photos)
    if control and len(usable_labels) < MIN_POINTS:
        unlocated_labels = [label for label in control if label not in usable_labels]
        findings.append(
            Finding(
                "control.too-few",
                "info",
                count=len(usable_labels),
                total=len(control),
                least=MIN_POINTS,
                photos=MIN_PHOTOS,
                reasons=_few_marks_text(
                    _marks(label, len(_marked_photos(marking, label, allowed_photos)))
                    for label in unlocated_labels
                ),
                labels=unlocated_labels,
            )
        )
    elif control and _is_collinear(marking, usable_labels):
        findings.append(Finding("control.collinear", "info"))
    unseen_labels = [
        p.label
        for p in marking.control
        if p.check and len(_marked_photos(marking, p.label, allowed_photos)) < MIN_PHOTOS
    ]
    if unseen_labels:
        findings.append(Finding("control.few-marks", "info", labels=unseen_labels))
    if placed_photos is not None and allowed_photos is not None:
        findings += _missing_joins(marking, placed_photos, allowed_photos)
    return findings


def _missing_joins(
    marking: ControlMarks, placed_photos: PlacedPhotos, model: set[str]
) -> list[Finding]:
    """Report what is still needed to join the other components.

    model : photos of the first component
    """
    findings = []
    for number, part in enumerate(placed_photos.parts[1:], start=2):
        part_names = {view.name for view in part.views}
        counts = {
            label: (
                len(_marked_photos(marking, label, model)),
                len(_marked_photos(marking, label, part_names)),
            )
            for label in marking.labels
        }
        joined_labels = [
            label for label, view_counts in counts.items() if min(view_counts) >= MIN_PHOTOS
        ]
        if len(joined_labels) < MIN_POINTS:
            findings.append(
                Finding(
                    "join.few-markers",
                    "info",
                    size=len(part_names),
                    common=len(joined_labels),
                    least=MIN_POINTS,
                    markers=joined_labels,
                    not_located=[
                        label
                        for label, (_, b) in counts.items()
                        if label not in joined_labels and b
                    ],
                )
            )
            started_labels = [
                tr(
                    "{point} ({first} in the model, {second} in component {number})",
                    point=label,
                    first=a,
                    second=b,
                    number=number,
                )
                for label, (a, b) in counts.items()
                if label not in joined_labels and b
            ]
            if started_labels:
                findings.append(
                    Finding("join.begun-markers", component=number, markers=started_labels)
                )
    return findings


def _few_marks_text(points: Iterable[str]) -> str:
    """Format points with their numbers of marks as text; empty if there are no points."""
    names = ", ".join(points)
    return names and tr("Too few marks: {points}.", points=names)


def _marked_photos(marking: ControlMarks, label: str, photos: set[str] | None) -> list[str]:
    return [name for name in marking.of(label) if photos is None or name in photos]


def _is_collinear(marking: ControlMarks, labels: Sequence[str]) -> bool:
    points = np.array([p.position for p in marking.control if p.label in labels], np.float64)
    return is_nearly_collinear(points)


def _marks(label: str, count: int) -> str:
    """Return a point and its number of marks as text."""
    return tr_n("{point} ({count} mark)", "{point} ({count} marks)", count, point=label)
