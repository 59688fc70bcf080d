"""Control that turns out to be unusable after the alignment costs no model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.photogrammetry.georeferencing.test_control import exchanged, marked
from tests.photogrammetry.georeferencing.test_georeference import scene_of
from tests.photogrammetry.made_photos import ORIGIN, MadePhoto, around, face
from vomstudio.core.progress import SilentProgress
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align.alignment import Alignment
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.pipeline.photo_input import ControlTables
from vomstudio.photogrammetry.pipeline.placing import place_scene, registration_findings

VIEWS = around()
CONTROL = PipelineSettings(control=Path("control.csv"), marks=Path("marks.csv"), threads=1)
Tables = tuple[list[ControlPoint], list[Mark]]


class UprightPhoto(MadePhoto):
    orientation = 1


def placed(
    settings: PipelineSettings,
    control: list[ControlPoint],
    marks: list[Mark],
    positions: np.ndarray | None = None,
) -> tuple[SparseScene, dict[str, Any], list[str]]:
    """The scene, its registration, and the codes of findings on it."""
    alignment = Alignment((scene_of(VIEWS, face(60)),), (), 0.3, (), 60)
    photos: list[Any] = [UprightPhoto(Path(view.name), view.name) for view in VIEWS]
    if positions is not None:
        photos = [
            replace(photo, longitude_deg=x, latitude_deg=y, altitude_m=z)
            for photo, (x, y, z) in zip(photos, positions.tolist(), strict=True)
        ]
    tables = ControlTables(tuple(control), tuple(marks), "EPSG:32632", ("a", "b"))
    scene, facts = place_scene(alignment, photos, settings, tables, SilentProgress())
    return scene, facts, [f.code for f in registration_findings(settings, facts)]


def wild(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    rng = np.random.default_rng(0)
    pixels = rng.uniform(100, 1100, (len(marks), 2)).tolist()
    return control, [replace(m, x=x, y=y) for m, (x, y) in zip(marks, pixels, strict=True)]


def in_other_photos(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    return control, [replace(mark, photo=f"not aligned {mark.photo}") for mark in marks]


def in_one_photo_each(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    return control, list({mark.label: mark for mark in marks}.values())


def only_two(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    return control, [mark for mark in marks if mark.label in "AB"]


def on_a_line(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    line = [
        replace(point, position=(ORIGIN[0] + 3.0 * i, ORIGIN[1], ORIGIN[2]))
        for i, point in enumerate(control)
    ]
    return line, marks


def at_one_place(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    """All labels are marked at the same point of the rock."""
    there = {mark.photo: mark for mark in marks if mark.label == "C"}
    return control, [replace(there[m.photo], label=m.label) for m in marks if m.photo in there]


def with_exchanged_labels(control: list[ControlPoint], marks: list[Mark]) -> Tables:
    return exchanged(control, "ABCDE"), marks


@pytest.mark.parametrize(
    "spoil",
    [
        wild,
        in_other_photos,
        in_one_photo_each,
        only_two,
        on_a_line,
        at_one_place,
        with_exchanged_labels,
    ],
)
def test_insufficient_control_gives_a_local_frame_and_a_finding(
    spoil: Callable[[list[ControlPoint], list[Mark]], Tables],
) -> None:
    scene, facts, codes = placed(CONTROL, *spoil(*marked(VIEWS)))
    assert facts["refused"]
    assert codes == ["control-unused"]
    assert (scene.crs, scene.scaled, scene.origin) == (None, False, (0, 0, 0))
    assert len(scene.views) == len(VIEWS)
    assert np.isfinite(scene.points).all()


@pytest.mark.parametrize(("noise_px", "codes"), [(0.3, []), (25.0, ["mark-scatter"])])
def test_sufficient_control_registers_the_scene(noise_px: float, codes: list[str]) -> None:
    scene, facts, found = placed(CONTROL, *marked(VIEWS, noise_px))
    assert "refused" not in facts
    assert found == codes
    assert (scene.crs, scene.scaled) == ("EPSG:32632", True)


@pytest.mark.parametrize(("crs", "codes"), [(None, []), ("EPSG:32632", ["gps-unused"])])
def test_insufficient_gps_gives_a_local_frame(crs: str | None, codes: list[str]) -> None:
    same = np.tile([11.0, 46.0, 300.0], (len(VIEWS), 1))
    scene, facts, found = placed(PipelineSettings(crs=crs, threads=1), [], [], same)
    assert facts["refused"]
    assert found == codes
    assert (scene.crs, scene.scaled) == (None, False)
