"""Cameras as other programs write them, from known poses, by the formats' published layouts."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image
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


def openmvg_json(path: Path, views: Sequence[View]) -> Path:
    """Write a scene of OpenMVG; the last photo is not aligned."""
    fx, _, cx, cy, k1, k2, p1, p2 = LENS.params
    photo = {"local_path": "", "width": LENS.width, "height": LENS.height, "id_intrinsic": 7}
    rows = []
    for number, name in enumerate([*(view.name for view in views), "not_aligned.jpg"]):
        row = {**photo, "filename": name, "id_view": number, "id_pose": number}
        rows.append({"key": number, "value": {"ptr_wrapper": {"id": number, "data": row}}})
    lens = {
        "width": LENS.width,
        "height": LENS.height,
        "focal_length": fx,
        "principal_point": [cx, cy],
        "disto_t2": [k1, k2, 0.0, p1, p2],
    }
    lens_row = {"polymorphic_name": "pinhole_brown_t2", "ptr_wrapper": {"id": 1, "data": lens}}
    poses = [
        {"key": n, "value": {"rotation": v.rotation.tolist(), "center": v.centre.tolist()}}
        for n, v in enumerate(views)
    ]
    content = {
        "sfm_data_version": "0.3",
        "root_path": "photos",
        "views": rows,
        "intrinsics": [{"key": 7, "value": lens_row}],
        "extrinsics": poses,
    }
    path.write_text(json.dumps(content))
    return path


def alicevision_json(path: Path, views: Sequence[View], version: tuple[int, int, int]) -> Path:
    """Write a scene of AliceVision, as its versions before 1.2, 1.2.2 and after it do."""
    fx, fy, cx, cy, k1, k2, p1, p2 = LENS.params
    centre = [cx, cy]
    if version >= (1, 2, 1):
        centre = [cx - LENS.width / 2, cy - LENS.height / 2]
    lens: dict[str, object] = {
        "intrinsicId": "77",
        "width": str(LENS.width),
        "height": str(LENS.height),
        "type": "brown",
        "principalPoint": [repr(value) for value in centre],
        "distortionParams": [repr(value) for value in (k1, k2, 0.0, p1, p2)],
    }
    if version < (1, 2, 0):
        lens["pxFocalLength"] = repr(fx)
    elif version < (1, 2, 2):
        lens["pxFocalLength"] = [repr(fx), repr(fy)]
    else:
        lens |= {"sensorWidth": "8.0", "focalLength": repr(fx * 8.0 / LENS.width)}
    rows = [
        {"viewId": str(n), "poseId": str(n), "intrinsicId": "77", "path": rf"D:\photos\{v.name}"}
        for n, v in enumerate(views)
    ]
    rows.append({"viewId": "99", "poseId": "99", "intrinsicId": "77", "path": "D:/a.jpg"})
    poses = []
    for number, view in enumerate(views):
        # Matrices are written column by column.
        rotation = [repr(float(value)) for value in view.rotation.T.ravel()]
        transform = {"rotation": rotation, "center": [repr(float(c)) for c in view.centre]}
        poses.append({"poseId": str(number), "pose": {"transform": transform, "locked": "0"}})
    content = {
        "version": [str(number) for number in version],
        "views": rows,
        "intrinsics": [lens],
        "poses": poses,
    }
    path.write_text(json.dumps(content))
    return path


def nerfstudio_json(path: Path, views: Sequence[View], applied: Array | None = None) -> Path:
    """Write the frames of nerfstudio; `applied` (3, 4) leads from the frame of the views."""
    fx, fy, cx, cy, k1, k2, p1, p2 = LENS.params
    turn = np.eye(3, 4) if applied is None else applied
    frames = []
    for view in views:
        matrix = np.eye(4)
        matrix[:3, :3] = turn[:, :3] @ view.rotation.T @ np.diag([1.0, -1.0, -1.0])
        matrix[:3, 3] = turn[:, :3] @ view.centre + turn[:, 3]
        frames.append({"file_path": f"./{view.name}", "transform_matrix": matrix.tolist()})
    content: dict[str, object] = {"w": LENS.width, "h": LENS.height, "fl_x": fx, "fl_y": fy}
    content |= {"cx": cx, "cy": cy, "k1": k1, "k2": k2, "p1": p1, "p2": p2, "frames": frames}
    if applied is not None:
        content["applied_transform"] = applied.tolist()
    path.write_text(json.dumps(content))
    return path


def photos_of(folder: Path, views: Sequence[View]) -> None:
    """Write grey photos of the sizes of the views."""
    for view in views:
        size = (view.intrinsics.width, view.intrinsics.height)
        Image.new("L", size).save(folder / view.name)


def bundler_out(path: Path, views: Sequence[View]) -> Path:
    """Write cameras of Bundler with the model RADIAL and its list; the second is not aligned."""
    flip = np.diag([1.0, -1.0, -1.0])
    blocks = []
    for view in views:
        focal, _, _, k1, k2 = view.intrinsics.params
        rows = [[focal, k1, k2], *(flip @ view.rotation).tolist(), flip @ view.translation]
        blocks.append("\n".join(" ".join(f"{value!r}" for value in map(float, r)) for r in rows))
    blocks.insert(1, "\n".join(["0 0 0"] * 5))
    names = [view.name for view in views]
    names.insert(1, "not_aligned.jpg")
    point = "1.0 2.0 3.0\n255 0 0\n1 0 7 10.5 -20.5\n"
    path.write_text(f"# Bundle file v0.3\n{len(blocks)} 1\n" + "\n".join(blocks) + f"\n{point}")
    path.with_name("list.txt").write_text("\n".join(f"./{name} 0 320.0" for name in names))
    return path


def reality_capture_csv(path: Path, views: Sequence[View], k4: float = 0.0) -> Path:
    """Write the table of RealityCapture with the lens of FULL_OPENCV and a further term."""
    rows = ["#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2"]
    for view in views:
        lens = view.intrinsics
        side = max(lens.width, lens.height)
        fx, _, cx, cy, k1, k2, p1, p2, k3 = lens.params[:9]
        to_world = Rotation.from_matrix(view.rotation.T @ np.diag([1.0, -1.0, -1.0]))
        yaw, pitch, roll = to_world.as_euler("ZXY", degrees=True)
        centre = [(cx - lens.width / 2) / side, (cy - lens.height / 2) / side]
        values = [*view.centre, -yaw, pitch, roll, fx / side * 36.0, *centre]
        values += [k1, k2, k3, k4, p1, p2]
        rows.append(",".join([view.name, *(f"{value!r}" for value in map(float, values))]))
    path.write_text("\n".join(rows) + "\n")
    return path


def micmac_folder(folder: Path, views: Sequence[View], places: Array) -> Path:
    """Write orientations with a lens of Fraser and points for checking."""
    folder.mkdir(parents=True)
    f, _, cx, cy, k1, k2, p1, p2 = LENS.params
    lens = (
        f"<ExportAPERO><CalibrationInternConique><KnownConv>eConvApero_DistM2C</KnownConv>"
        f"<PP>{cx!r} {cy!r}</PP><F>{f!r}</F><SzIm>{LENS.width} {LENS.height}</SzIm>"
        f"<CalibDistortion><ModPhgrStd><RadialePart><CDist>{cx!r} {cy!r}</CDist>"
        f"<CoeffDist>{k1 / f**2!r}</CoeffDist><CoeffDist>{k2 / f**4!r}</CoeffDist></RadialePart>"
        f"<P1>{p2 / f!r}</P1><P2>{p1 / f!r}</P2></ModPhgrStd></CalibDistortion>"
        f"</CalibrationInternConique></ExportAPERO>"
    )
    (folder / "AutoCal_Foc-28000.xml").write_text(lens)
    for view in views:
        rows = "".join(
            f"<L{n}>{' '.join(map(repr, row.tolist()))}</L{n}>"
            for n, row in enumerate(view.rotation.T, 1)
        )
        checks = "".join(
            f"<Appuis><Num>{n}</Num><Im>{' '.join(map(repr, pixel.tolist()))}</Im>"
            f"<Ter>{' '.join(map(repr, place.tolist()))}</Ter></Appuis>"
            for n, (pixel, place) in enumerate(zip(view.project(places), places, strict=True))
        )
        (folder / f"Orientation-{view.name}.xml").write_text(
            "<ExportAPERO><OrientationConique><TypeProj>eProjStenope</TypeProj>"
            "<FileInterne>Ori-All/AutoCal_Foc-28000.xml</FileInterne><Externe>"
            f"<Centre>{' '.join(map(repr, view.centre.tolist()))}</Centre>"
            f"<ParamRotation><CodageMatr>{rows}</CodageMatr></ParamRotation></Externe>"
            f"<Verif><Tol>0.001</Tol>{checks}</Verif>"
            "<ConvOri><KnownConv>eConvApero_DistM2C</KnownConv></ConvOri>"
            "</OrientationConique></ExportAPERO>"
        )
    return folder


def colmap_itself(folder: Path, views: Sequence[View], binary: bool = True) -> Path:
    """Let COLMAP write its model of the views."""
    # pycolmap brings a zlib of its own, so Pillow has to be imported before it.
    import pycolmap

    made = pycolmap.Reconstruction()
    lens = views[0].intrinsics
    camera = pycolmap.Camera(
        camera_id=1, model=lens.model, width=lens.width, height=lens.height, params=lens.params
    )
    made.add_camera_with_trivial_rig(camera)
    for number, view in enumerate(views, 1):
        image = pycolmap.Image(name=view.name, camera_id=1, image_id=number)
        image.points2D = pycolmap.Point2DList([pycolmap.Point2D([1.5, 2.5])] * number)
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(view.rotation), view.translation)
        made.add_image_with_trivial_frame(image, pose)
    folder.mkdir()
    (made.write_binary if binary else made.write_text)(str(folder))
    return folder
