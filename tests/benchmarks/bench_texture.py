"""Surface, atlas and texture of a rock face whose shape and colours are known.

    python -m tests.benchmarks.bench_texture [--photos 12] [--width 1200] [--open3d] [--threads 2]

Twelve photos of 1 MP of a face 14 x 9 m with joint steps, differing in exposure, one with something
green before the rock; a cloud as a dense matching would leave it. Reported: seconds (wall and
processor) and peak memory of each step, the surface beside the true one, and of the texture, drawn
parallel to the face beside the same picture of the truth: contrast and correlation of bands from
0.7 and 1.4 texels up, the smoothed error in values of 0..255, what is left of the green thing, and
the steps along seams between photos against steps elsewhere. With --open3d, also Open3D's
`compute_uvatlas` and `project_images_to_albedo` on the same surface.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from tests.photogrammetry import rock_face as rock
from tests.photogrammetry.surface.texture_truth import Comparison, compare
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.photogrammetry.surface.meshing import MeshingOptions, build_surface
from vomstudio.photogrammetry.surface.texture import make_texture
from vomstudio.studio.jobs.executors import Threads

BOX = (-6.2, 6.2, -3.1, 3.1)
GREEN = (600.0, 430.0, 100.0, 130.0)


def timed(name: str, work: Callable[[], Any]) -> Any:
    wall, used = time.perf_counter(), time.process_time()
    result = work()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(
        f"{name}: {time.perf_counter() - wall:.1f} s, processor {time.process_time() - used:.1f} s,"
        f" peak so far {peak:.2f} GB",
        flush=True,
    )
    return result


def seams(seen: Comparison, source_photos: Any) -> float:
    """Change of the residual from pixel to pixel where the photo changes, over that elsewhere on
    surfaces that are not steep."""
    photo = np.where(seen.face >= 0, source_photos[seen.face], -2)
    across = np.abs(np.diff(cv2.GaussianBlur(seen.residual, (0, 0), 1.0), axis=1)).mean(-1)
    quiet = seen.covered & (cv2.erode(seen.covered.astype(np.uint8), np.ones((7, 7))) > 0)
    pair = quiet[:, 1:] & quiet[:, :-1]
    border = pair & (photo[:, 1:] != photo[:, :-1])
    return float(np.median(across[border]) / np.median(across[pair & ~border]))


def judge(name: str, seen: Comparison, source_photos: Any = None) -> None:
    excess = cv2.GaussianBlur(seen.residual[..., 1] - seen.residual[..., 0], (0, 0), 3)
    line = (
        f"{name}: contrast {seen.sharpness(0.7):.2f} / {seen.sharpness(1.4):.2f} of the truth,"
        f" correlation {seen.likeness(0.7):.3f} / {seen.likeness(1.4):.3f},"
        f" smoothed error {seen.low_error():.2f}, all {seen.residual[seen.covered].std():.2f},"
        f" green left {np.percentile(excess[seen.covered], 99.9):.0f}"
    )
    if source_photos is not None:
        line += f", steps at seams {seams(seen, source_photos):.2f} of elsewhere"
    print(line, flush=True)


def off_truth(mesh: Mesh, face: rock.Face) -> str:
    import open3d as o3d

    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(area), 100_000, p=area / area.sum())
    weights = rng.dirichlet(np.ones(3), len(chosen))
    points = (corners[chosen] * weights[..., None]).sum(1)
    found = face.scene.compute_closest_points(o3d.core.Tensor(points.astype(np.float32)))
    off = np.linalg.norm(points - found["points"].numpy(), axis=1) * 1000
    cosine = (cross[chosen] * found["primitive_normals"].numpy()).sum(1) / area[chosen]
    turn = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return (
        f"off the truth by median {np.median(off):.2f}, 95 % {np.percentile(off, 95):.1f} mm;"
        f" normals by median {np.median(turn):.1f}, 90 % {np.percentile(turn, 90):.1f} deg"
    )


def of_open3d(mesh: Mesh, taken: list, texels: int) -> tuple[Mesh, Any]:
    import open3d as o3d

    made = o3d.t.geometry.TriangleMesh(
        o3d.core.Tensor(mesh.vertices.astype(np.float32)), o3d.core.Tensor(mesh.faces)
    )
    timed("Open3D uvatlas", lambda: made.compute_uvatlas(size=texels, gutter=4, nthreads=2))
    images, lenses, poses = [], [], []
    for photo in taken:
        picture = cv2.imdecode(np.frombuffer(photo.photo, np.uint8), cv2.IMREAD_COLOR)
        images.append(o3d.t.geometry.Image(np.ascontiguousarray(picture[..., ::-1])))
        lens = photo.view.intrinsics.matrix
        lens[:2, 2] -= 0.5
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = photo.view.rotation, photo.view.translation
        lenses.append(o3d.core.Tensor(lens))
        poses.append(o3d.core.Tensor(pose))
    page = timed(
        "Open3D project_images_to_albedo",
        lambda: made.project_images_to_albedo(images, lenses, poses, tex_size=texels),
    )
    uv = made.triangle["texture_uvs"].numpy().reshape(-1, 2)
    faces = np.arange(len(uv), dtype=np.int32).reshape(-1, 3)
    old = made.triangle.indices.numpy().ravel()
    offsets = np.array([0, len(faces)])
    one = Mesh(mesh.vertices[old], faces, (Material("one"),), offsets, uv.astype(np.float32))
    return one, page.as_tensor().numpy()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--photos", type=int, default=12)
    parser.add_argument("--width", type=int, default=1200, help="of the photos, pixels")
    parser.add_argument("--faces", type=int, default=200_000)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--open3d", action="store_true")
    args = parser.parse_args()
    scale = args.width / 1200
    size = (args.width, round(864 * scale))
    face = rock.rough_face()
    face = rock.Face(face.vertices, face.faces, rock.rock_paint(7, finest=0.02 / scale))
    columns = max(args.photos // 2, 1)
    views = rock.ring_of_views(2, columns, size=size, focal=1100.0 * scale)
    rng = np.random.default_rng(5)
    gains = np.exp(rng.normal(0, 0.12, (len(views), 1)) + rng.normal(0, 0.03, (len(views), 3)))
    taken = []
    for k, view in enumerate(views):
        green = tuple(scale * v for v in GREEN) if k == min(3, len(views) - 1) else None
        picture = rock.photograph(face, view, gain=tuple(gains[k]), occluder=green, seed=k)
        taken.append(rock.taken(view, picture, ending=".jpg"))
    cloud = rock.cloud_of(face, views, spacing=0.0125, noise=0.002)
    print(f"{len(views)} photos of {size[0]} x {size[1]}, {len(cloud.points):,} points", flush=True)
    options = MeshingOptions(faces=args.faces, threads=args.threads)
    surface = timed("surface", lambda: build_surface(cloud, options)).mesh
    print(f"{len(surface.faces):,} faces, {off_truth(surface, face)}")
    made = timed("texture", lambda: make_texture(surface, taken, executor=Threads(args.threads)))
    report = made.report
    print(
        f"{len(made.pages)} pages {report.pages}, {report.charts} charts, texel"
        f" {1000 * report.texel_m:.2f} mm, unseen {report.unseen_share:.1%}"
    )
    found = np.array([report.gains[view.name] for view in views]) * gains
    found /= np.exp(np.log(found).mean(axis=0))
    print(f"gains within {np.abs(found - 1).max():.3f}, mean {np.abs(found - 1).mean():.4f}")
    step = report.texel_m
    judge("ours", compare(made.mesh, made.pages, face, step=step, box=BOX), made.source_photos)
    if args.open3d:
        mesh, page = of_open3d(surface, taken, 4096 if scale > 1 else 2048)
        judge("Open3D", compare(mesh, (page,), face, step=step, box=BOX))


if __name__ == "__main__":
    main()
