"""Fractures that the window counts on a wall, a slope and a pavement: strikes, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.cli.common.entry import main
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.units import Axes
from vomstudio.products.section.trace_map import write_map
from vomstudio.ui.panels.fractures.analysis import (
    CIRCLE,
    SCANLINE,
    WINDOW,
    FractureRequest,
    FractureResult,
    MappedTrace,
    analyse_fractures,
)
from vomstudio.ui.panels.fractures.fractures_panel import fractures_command

AT = np.array([400.0, 5_200.0, 90.0])
SLOPE, PAVEMENT, WALL = Plane(135.0, 30.0), Plane(0.0, 0.0), Plane(200.0, 90.0)


def request(face: Plane, counted_in: str, place: tuple[float, ...]) -> FractureRequest:
    """Level traces, and traces that go straight up the face (on a pavement east, and north)."""
    right, up = np.asarray(face.strike_vector()) * -1.0, np.asarray(face.dip_vector()) * -1.0
    traces = []
    for k, (x, y) in enumerate([(0, 1), (0, 2), (0, 3), (2, 0), (5, 0)]):
        ends = [(x, y), (x + 7, y)] if k < 3 else [(x, y), (x, y + 4)]
        points = np.array([AT + a * right + b * up for a, b in ends])
        traces.append(MappedTrace(f"t{k}", f"T{k}", "level" if k < 3 else "up", "#000000", points))
    return FractureRequest(traces, face, counted_in, place, FractureOptions(), True, True)


def answered(face: Plane, counted_in: str = WINDOW, place: tuple[float, ...] = ()):
    made = analyse_fractures(request(face, counted_in, place))
    assert isinstance(made, FractureResult)
    assert made.network is not None, made.reason
    return made


def strikes(made: FractureResult) -> dict[str, float]:
    assert made.network is not None
    return {s.name: s.strike_deg for s in made.network.statistics.sets}


def axial(angle: float, other: float) -> float:
    return abs((angle - other + 90.0) % 180.0 - 90.0)


def test_fracture_azimuths_on_slope_and_pavement_are_strikes() -> None:
    made = strikes(answered(SLOPE))
    assert axial(made["level"], SLOPE.strike_rhr_deg) < 1e-6
    assert axial(made["up"], SLOPE.dip_direction_deg) < 1e-6
    made = strikes(answered(PAVEMENT))
    assert axial(made["level"], 90.0) < 1e-6
    assert axial(made["up"], 0.0) < 1e-6


def test_fracture_azimuths_on_a_wall_are_measured_from_up() -> None:
    made = strikes(answered(WALL))
    assert axial(made["level"], 90.0) < 1e-6
    assert axial(made["up"], 0.0) < 1e-6


def nearly(value):
    """The same to rounding: areas go from the face to World and back."""
    if isinstance(value, dict):
        return {key: nearly(each) for key, each in value.items()}
    if isinstance(value, list):
        return [nearly(each) for each in value]
    return pytest.approx(value, rel=1e-7, abs=1e-7) if isinstance(value, float) else value


@pytest.mark.parametrize(
    "face", first_in_default_tier([WALL, SLOPE, PAVEMENT]), ids=["wall", "slope", "pavement"]
)
@pytest.mark.parametrize("counted_in", first_in_default_tier([WINDOW, CIRCLE, SCANLINE]))
def test_the_copied_command_has_the_same_figures(
    face: Plane, counted_in: str, tmp_path: Path, capfd
) -> None:
    low = np.concatenate(answered(face).lines).min(axis=0)
    place = {
        WINDOW: (*(low + [1.0, -0.5]), *(low + [6.0, 3.5])),
        CIRCLE: (*(low + [3.0, 2.0]), 1.5),
        SCANLINE: (*(low + [3.0, 0.5]), *(low + [3.5, 3.6])),
    }[counted_in]
    made = answered(face, counted_in, tuple(float(v) for v in place))
    q = made.request
    path = tmp_path / "traces.gpkg"
    write_map(
        path,
        [t.points for t in q.traces],
        [t.name for t in q.traces],
        [t.set for t in q.traces],
        made.region,
        made.face,
        crs=Axes().wkt,
    )
    words = [
        text
        for word in fractures_command(made, path)
        for text in (map(str, word) if isinstance(word, tuple) else [str(word)])
    ]
    assert main([*words, "--json"]) == 0
    said = json.loads(capfd.readouterr().out)
    said.pop("image")
    assert made.network is not None
    mine = json.dumps(made.network.statistics.to_dict(), default=lambda finding: finding.to_dict())
    assert said == nearly(json.loads(mine))
