"""Ways over open models, searched for beside the owner's thread."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.extraction.planes_by_construction import grid_mesh
from tests.studio.loop import Loop
from vomstudio.geometry.mesh import Mesh
from vomstudio.studio.background import Background
from vomstudio.studio.path_finding import PathFinding

A, B, C = (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 0.0, 0.0)


@pytest.fixture
def loop() -> Loop:
    return Loop()


@pytest.fixture
def paths(loop: Loop) -> PathFinding:
    flat = grid_mesh(np.zeros((41, 41)), 0.05)
    apart = Mesh(
        np.concatenate([flat.vertices, flat.vertices + [100.0, 0.0, 0.0]]),
        np.concatenate([flat.faces, flat.faces + len(flat.vertices)]),
    )
    models: Any = SimpleNamespace(open_models={"m": SimpleNamespace(data=apart)})
    return PathFinding(models, Background(loop.post, "path finding", threads=1))


def ended() -> bool:
    return not any(thread.name == "path finding" for thread in threading.enumerate())


def test_path_arrives_in_the_owner_thread(loop: Loop, paths: PathFinding) -> None:
    found: list[tuple[Any, threading.Thread]] = []
    paths.follow(
        "m",
        "curvature",
        (A, B),
        is_live=False,
        callback=lambda path: found.append((path, threading.current_thread())),
    )
    assert found == []
    assert loop.run_until(lambda: bool(found) and ended(), 20.0)
    path, thread = found[0]
    assert thread is threading.current_thread()
    assert np.array_equal(path.points[0], A)
    assert np.array_equal(path.points[-1], B)


def test_only_the_latest_path_to_the_cursor_arrives(loop: Loop, paths: PathFinding) -> None:
    found: list[str] = []
    # The first one makes the graph, while the others wait.
    paths.follow("m", "curvature", (A, B), is_live=False, callback=lambda _: found.append("leg"))
    for name, end in (("old", B), ("older", C), ("last", B)):
        paths.follow(
            "m", "curvature", (A, end), is_live=True, callback=lambda _, n=name: found.append(n)
        )
    assert loop.run_until(lambda: "last" in found and ended(), 20.0)
    assert found[0] == "leg"
    assert found[-1] == "last"
    assert len(found) <= 3


def test_path_that_cannot_be_followed_returns_a_finding(loop: Loop, paths: PathFinding) -> None:
    found: list[Any] = []
    far = (101.0, 0.0, 0.0)
    paths.follow("m", "curvature", (A, far), is_live=False, callback=found.append)
    paths.follow("m", "dark", (A, B), is_live=False, callback=found.append)
    paths.follow("gone", "dark", (A, B), is_live=False, callback=found.append)
    assert loop.run_until(lambda: len(found) == 3 and ended(), 20.0)
    assert sorted(each.code for each in found) == sorted(
        ["path.separate-parts", "model.no-colours", "model.not-open"]
    )


def test_closing_the_project_cancels_path_searches(loop: Loop, paths: PathFinding) -> None:
    found: list[Any] = []
    for end in (B, C, B):
        paths.follow("m", "curvature", (A, end), is_live=False, callback=found.append)
    paths.clear_state()
    assert loop.run_until(ended, 20.0)
    loop.run_until(lambda: False, 0.1)
    assert len(found) <= 1
