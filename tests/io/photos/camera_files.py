"""Cameras as other programs write them, from known poses, by the formats' published layouts."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from vomstudio.geometry.cameras import Intrinsics, View

Array = npt.NDArray[np.float64]

LENS = Intrinsics("OPENCV", 4000, 3000, (3200.0, 3200.0, 2010.0, 1490.0, -0.05, 0.01, 1e-4, 2e-4))


def ring(count: int = 9, seed: int = 2) -> list[View]:
    """Cameras around the origin that look at it, none of them level or in order."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0.0, 2.6, count)
    centres = np.column_stack([14 * np.cos(angles), 14 * np.sin(angles), 2 + angles])
    centres += rng.normal(size=centres.shape)
    views = []
    for number, centre in enumerate(centres):
        forward = -centre / np.linalg.norm(centre)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        level = np.array([right, np.cross(forward, right), forward])
        rotation = Rotation.from_rotvec(rng.normal(size=3) * 0.1).as_matrix() @ level
        views.append(View(f"IMG_{number:02d}.jpg", LENS, rotation, -rotation @ centre))
    return views


def _quaternion(view: View) -> list[float]:
    x, y, z, w = Rotation.from_matrix(view.rotation).as_quat()
    return [w, x, y, z]


def colmap_text(folder: Path, views: Sequence[View]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    params = " ".join(f"{p!r}" for p in LENS.params)
    (folder / "cameras.txt").write_text(
        "# Camera list with one line of data per camera:\n"
        "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        f"1 OPENCV {LENS.width} {LENS.height} {params}\n"
    )
    lines = ["# Image list with two lines of data per image:"]
    for number, view in enumerate(views, 1):
        pose = [*_quaternion(view), *view.translation.tolist()]
        lines.append(f"{number} {' '.join(map(repr, map(float, pose)))} 1 {view.name}")
        # The second line may be empty.
        lines.append("" if number % 2 else "10.5 20.5 -1 30.5 40.5 7")
    (folder / "images.txt").write_text("\n".join(lines) + "\n")
    return folder


def metashape_xml(
    path: Path, views: Sequence[View], scale: float, turn: Array, shift: Array, reference: str = ""
) -> Path:
    """A chunk whose transform (scale, turn, shift) leads to the frame of the views."""
    cameras = []
    for number, view in enumerate(views):
        # From the camera to the frame, and back through the transform of the chunk.
        matrix = np.eye(4)
        matrix[:3, :3] = turn.T @ view.rotation.T
        matrix[:3, 3] = turn.T @ (view.centre - shift) / scale
        text = " ".join(f"{v:.16e}" for v in matrix.ravel())
        cameras.append(
            f'<camera id="{number}" sensor_id="0" component_id="0" '
            f'label="{view.name.removesuffix(".jpg")}"><transform>{text}</transform>'
            "<orientation>1</orientation></camera>"
        )
    cameras.append('<camera id="99" sensor_id="0" label="not_aligned"/>')
    fx, _, cx, cy, k1, k2, p1, p2 = LENS.params
    lens = (
        f"<f>{fx!r}</f><cx>{cx - LENS.width / 2!r}</cx><cy>{cy - LENS.height / 2!r}</cy>"
        f"<k1>{k1!r}</k1><k2>{k2!r}</k2><p1>{p2!r}</p1><p2>{p1!r}</p2>"
    )
    size = f'<resolution width="{LENS.width}" height="{LENS.height}"/>'
    rows = " ".join(f"{v:.16e}" for v in turn.ravel())
    there = " ".join(f"{v:.16e}" for v in shift)
    path.write_text(
        f'<?xml version="1.0" encoding="UTF-8"?>\n<document version="2.0.0">\n'
        f'<chunk label="Chunk 1" enabled="true">\n<sensors next_id="1"><sensor id="0" '
        f'label="a" type="frame">{size}<calibration type="frame" class="adjusted">{size}{lens}'
        f"</calibration></sensor></sensors>\n"
        f'<components next_id="1"><component id="0" label="C"><transform><rotation>{rows}'
        f"</rotation><translation>{there}</translation><scale>{scale!r}</scale></transform>"
        f'</component></components>\n<cameras next_id="99">\n'
        + "\n".join(cameras)
        + f"\n</cameras>\n<reference>{reference}</reference>\n</chunk>\n</document>\n"
    )
    return path


def opensfm_json(path: Path, views: Sequence[View]) -> Path:
    side = float(LENS.width)
    fx, fy, cx, cy, k1, k2, p1, p2 = LENS.params
    camera = {
        "projection_type": "brown",
        "width": LENS.width,
        "height": LENS.height,
        "focal_x": fx / side,
        "focal_y": fy / side,
        "c_x": (cx - LENS.width / 2) / side,
        "c_y": (cy - LENS.height / 2) / side,
        "k1": k1,
        "k2": k2,
        "k3": 0.0,
        "p1": p1,
        "p2": p2,
    }
    shots = {
        view.name: {
            "rotation": Rotation.from_matrix(view.rotation).as_rotvec().tolist(),
            "translation": view.translation.tolist(),
            "camera": "v2 a",
            "orientation": 1,
        }
        for view in views
    }
    small = {"cameras": {"v2 a": camera}, "shots": {"other.jpg": next(iter(shots.values()))}}
    whole = {"cameras": {"v2 a": camera}, "shots": shots, "points": {}}
    path.write_text(json.dumps([small, whole]))
    return path


def shots_geojson(path: Path, views: Sequence[View]) -> Path:
    features = [
        {
            "type": "Feature",
            "properties": {
                "filename": view.name,
                "focal": 0.8,
                "width": LENS.width,
                "height": LENS.height,
                "translation": view.centre.tolist(),
                "rotation": Rotation.from_matrix(view.rotation).as_rotvec().tolist(),
            },
            "geometry": {"type": "Point", "coordinates": [13.0, 45.0, 300.0]},
        }
        for view in views
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def metashape_reference(path: Path, views: Sequence[View]) -> Path:
    """With given places that are wrong, and the estimated ones."""
    rows = [
        f"{v.name.removesuffix('.jpg')},{i}.0,5.0,6.0," + ",".join(f"{c:.9f}" for c in v.centre)
        for i, v in enumerate(views)
    ]
    path.write_text(
        "# CoordinateSystem: Local Coordinates (m)\n"
        "#Label,X/East,Y/North,Z/Altitude,X_est,Y_est,Z_est\n" + "\n".join(rows) + "\n"
    )
    return path


def metashape_angles(path: Path, views: Sequence[View]) -> Path:
    """The table of positions and omega, phi, kappa."""
    rows = [
        "\t".join([v.name.removesuffix(".jpg"), *(f"{c:.9f}" for c in (*v.centre, 1.0, 2.0, 3.0))])
        for v in views
    ]
    path.write_text(
        f"# Cameras ({len(views)})\n# PhotoID\tX\tY\tZ\tOmega\tPhi\tKappa\n"
        + "\n".join(rows)
        + "\n"
    )
    return path
