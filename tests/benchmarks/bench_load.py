"""How long models take to load, beside CloudCompare and other libraries, in one run.

    python -m tests.benchmarks.bench_load [--dir FOLDER] [--runs 3] [--small] [--peer-python PYTHON]

The data are generated (a bumpy cliff of 100 x 60 m in four textured parts): an OBJ of 1 M triangles
with four 4096 x 4096 JPG textures, one of 5 M with the same textures, and a binary PLY of 5 M.
What is compared, each as the median of the runs:

- warm: `read_model` in a process that has read the file's format before, with the textures decoded
  by Pillow in threads (what a worker of the window does for its second model);
- process: a fresh Python that imports, reads and decodes (what the command line does);
- CloudCompare: its command line (`-SILENT -AUTO_SAVE OFF -O file`) as a whole process under Xvfb,
  and the same less its start, measured on a file of two triangles. It decodes the textures too;
- trimesh, Open3D: in a fresh Python each, timed inside it around the load call alone, so their
  import is not counted.

Processor seconds stand beside wall seconds, for machines that are busy with other work too.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SIZE = (100.0, 60.0)

OURS = """
import json, resource, sys, time
start = time.perf_counter()
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from vomstudio.io.models.opening import read_model
def decode(path):
    from PIL import Image
    image = Image.open(path)
    image.load()
    return image
def load():
    model = read_model(Path(sys.argv[1]))
    paths = dict.fromkeys(m.texture for m in getattr(model.data, "materials", ()) if m.texture)
    with ThreadPoolExecutor() as pool:
        images = list(pool.map(decode, paths))
    return model, images
times = []
for _ in range(int(sys.argv[2])):
    t, cpu = time.perf_counter(), time.process_time()
    model, images = load()
    times.append((time.perf_counter() - t, time.process_time() - cpu))
    faces, textures = len(model.data.faces), len(images)
    del model, images
print(json.dumps({"times": times, "faces": faces, "textures": textures,
                  "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
"""

PEERS = {
    "trimesh": """
import json, sys, time
import trimesh
import PIL.Image
PIL.Image.MAX_IMAGE_PIXELS = None
t = time.perf_counter()
scene = trimesh.load(sys.argv[1], process=False)
for mesh in getattr(scene, "geometry", {"": scene}).values():
    image = getattr(getattr(mesh.visual, "material", None), "image", None)
    if image is not None:
        image.load()
print(json.dumps({"times": [time.perf_counter() - t]}))
""",
    "open3d": """
import json, sys, time
import open3d
t = time.perf_counter()
mesh = open3d.io.read_triangle_mesh(sys.argv[1], True)
print(json.dumps({"times": [time.perf_counter() - t]}))
""",
}


def relief(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    y = 2.5 * np.sin(x / 9) + 1.7 * np.sin(z / 6 + x / 15) + 0.9 * np.sin(x / 2.1) * np.sin(z / 1.7)
    for f, a in ((0.9, 0.25), (2.3, 0.12), (5.1, 0.05), (11.0, 0.02)):
        y = y + a * np.sin(f * x + 1.3 * f * z + f) * np.cos(f * z * 1.1 - 0.7 * f * x)
    return y


def parts(triangles: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Vertices, texture coordinates and faces of a 2 x 2 tiling of the cliff."""
    half = triangles / 2
    nx = round(np.sqrt(half * SIZE[0] / SIZE[1]))
    nz = round(half / nx)
    found = []
    for rows in np.array_split(np.arange(nz), 2):
        for columns in np.array_split(np.arange(nx), 2):
            i = np.arange(columns[0], columns[-1] + 2)
            j = np.arange(rows[0], rows[-1] + 2)
            x, z = np.meshgrid(i * SIZE[0] / nx, j * SIZE[1] / nz)
            u, v = np.meshgrid(np.linspace(0, 1, len(i)), np.linspace(0, 1, len(j)))
            a = (np.arange(len(j) - 1)[:, None] * len(i) + np.arange(len(i) - 1)).ravel()
            w = len(i)
            faces = np.concatenate(
                [np.stack([a, a + 1, a + w + 1], 1), np.stack([a, a + w + 1, a + w], 1)]
            )
            xyz = np.stack([x, relief(x, z), z], -1).reshape(-1, 3)
            found.append((xyz, np.stack([u, v], -1).reshape(-1, 2), faces))
    return found


def write_rows(file, pattern: str, values: np.ndarray) -> None:
    for block in np.array_split(values, max(1, len(values) // 100_000)):
        file.write((pattern * len(block)) % tuple(block.ravel().tolist()))


def make_obj(path: Path, triangles: int) -> None:
    if path.exists():
        return
    with open(path.with_suffix(".mtl"), "w") as file:
        for k in range(4):
            file.write(f"newmtl m{k}\nKd 1 1 1\nmap_Kd texture_{k}.jpg\n\n")
    draft = path.with_suffix(".part")
    with open(draft, "w") as file:
        file.write(f"mtllib {path.with_suffix('.mtl').name}\n")
        first = 1
        for k, (xyz, uv, faces) in enumerate(parts(triangles)):
            write_rows(file, "v %.4f %.4f %.4f\n", xyz)
            write_rows(file, "vt %.6f %.6f\n", uv)
            file.write(f"usemtl m{k}\n")
            write_rows(file, "f %d/%d %d/%d %d/%d\n", np.repeat(faces + first, 2, axis=1))
            first += len(xyz)
    draft.rename(path)


def make_ply(path: Path, triangles: int) -> None:
    if path.exists():
        return
    vertices, faces, first = [], [], 0
    for xyz, _, triangle in parts(triangles):
        vertices.append(xyz)
        faces.append(triangle + first)
        first += len(xyz)
    records = np.empty(sum(map(len, faces)), [("n", "u1"), ("corners", "<i4", (3,))])
    records["n"] = 3
    records["corners"] = np.concatenate(faces)
    draft = path.with_suffix(".part")
    with open(draft, "wb") as file:
        file.write(
            "ply\nformat binary_little_endian 1.0\n"
            f"element vertex {first}\nproperty double x\nproperty double y\nproperty double z\n"
            f"element face {len(records)}\nproperty list uchar int vertex_indices\n"
            "end_header\n".encode()
        )
        file.write(np.concatenate(vertices).astype("<f8").tobytes())
        file.write(records.tobytes())
    draft.rename(path)


def make_texture(path: Path, size: int, seed: int) -> None:
    if path.exists():
        return
    from PIL import Image

    rng = np.random.default_rng(seed)
    total = np.zeros((size, size), np.float32)
    cells = 8
    while cells <= size:
        noise = Image.fromarray((rng.random((cells, cells)) * 255).astype(np.float32))
        total += np.asarray(noise.resize((size, size), Image.Resampling.BILINEAR)) * cells**-0.5
        cells *= 2
    total = (total - total.min()) / np.ptp(total)
    color = np.array([[200, 180, 140], [150, 160, 170], [180, 140, 110], [140, 150, 120]])[seed % 4]
    pixels = np.clip(total[..., None] * 0.8 * color + 40, 0, 255).astype(np.uint8)
    Image.fromarray(pixels).save(path, quality=90)


def cpu_seconds() -> float:
    """Of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command: list[str]) -> tuple[float, float, str]:
    """Wall seconds, processor seconds, output."""
    cpu = cpu_seconds()
    start = time.perf_counter()
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        cwd=ROOT,
    )
    return time.perf_counter() - start, cpu_seconds() - cpu, done.stdout


def medians(measured: list[tuple[float, float]]) -> tuple[float, float]:
    return statistics.median(m[0] for m in measured), statistics.median(m[1] for m in measured)


def last_json(text: str) -> dict:
    return json.loads(text.strip().splitlines()[-1])


def cloudcompare(path: Path) -> tuple[float, float]:
    command = ["CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-O", str(path)]
    return run(["xvfb-run", "-a", *command])[:2]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dir", type=Path, default=ROOT / "tests" / "benchmarks" / "out")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--small", action="store_true", help="without the files of 5 M triangles")
    parser.add_argument("--make-only", action="store_true")
    parser.add_argument("--peer-python", help="a Python that has trimesh and/or open3d")
    options = parser.parse_args()
    folder: Path = options.dir
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(4):
        make_texture(folder / f"texture_{k}.jpg", 4096, k)
    files = {"OBJ 1 M, 4 textures": (folder / "cliff_1M.obj", 4.0)}
    make_obj(folder / "cliff_1M.obj", 1_000_000)
    if not options.small:
        make_obj(folder / "cliff_5M.obj", 5_000_000)
        make_ply(folder / "cliff_5M.ply", 5_000_000)
        files["OBJ 5 M, 4 textures"] = (folder / "cliff_5M.obj", 7.0)
        files["PLY 5 M binary"] = (folder / "cliff_5M.ply", 0.0)
    if options.make_only:
        return
    tiny = folder / "tiny.obj"
    tiny.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")

    has_cloudcompare = shutil.which("CloudCompare") and shutil.which("xvfb-run")
    if not has_cloudcompare:
        print("CloudCompare or xvfb-run is not installed: skipped")
    run([sys.executable, "-c", OURS, str(files["OBJ 1 M, 4 textures"][0]), "1"])  # compiles
    print(f"{os.cpu_count()} processors, load before: {os.getloadavg()[0]:.1f}")
    start = start_cpu = 0.0
    if has_cloudcompare:
        start, start_cpu = medians([cloudcompare(tiny) for _ in range(options.runs)])
        print(f"CloudCompare's start (two triangles): {start:.2f} s (CPU {start_cpu:.2f})")
    for name, (path, target) in files.items():
        print(f"\n{name}: {path.stat().st_size / 1e6:.0f} MB")
        inside = last_json(run([sys.executable, "-c", OURS, str(path), str(options.runs + 1)])[2])
        warm, warm_cpu = medians(inside["times"][1:])
        whole, peak = [], 0.0
        for _ in range(options.runs):
            seconds, cpu, text = run([sys.executable, "-c", OURS, str(path), "1"])
            whole.append((seconds, cpu))
            peak = last_json(text)["peak_mb"]
        process, process_cpu = medians(whole)
        print(
            f"  ours, warm {warm:.2f} s (CPU {warm_cpu:.2f}); whole process {process:.2f} s"
            f" (CPU {process_cpu:.2f}); peak {peak:.0f} MB; {inside['faces']:,} faces,"
            f" {inside['textures']} textures",
            flush=True,
        )
        if has_cloudcompare:
            other, other_cpu = medians([cloudcompare(path) for _ in range(options.runs)])
            print(
                f"  CloudCompare, whole process {other:.2f} s (CPU {other_cpu:.2f}):"
                f" {other / process:.1f} x our whole process (CPU {other_cpu / process_cpu:.1f} x);"
                f" less its start {(other - start) / warm:.1f} x our warm reader"
                f" (CPU {(other_cpu - start_cpu) / warm_cpu:.1f} x)"
                + (f"; wanted {target:.0f} x" if target else ""),
                flush=True,
            )
        for peer, script in PEERS.items():
            if not options.peer_python:
                print(f"  {peer}: no --peer-python given, skipped")
                continue
            try:
                times = [
                    last_json(run([options.peer_python, "-c", script, str(path)])[2])["times"][0]
                    for _ in range(options.runs)
                ]
            except subprocess.CalledProcessError as error:
                why = (error.stderr.strip().splitlines() or ["no reason given"])[-1]
                print(f"  {peer}: skipped ({why})")
                continue
            print(f"  {peer}, load call alone: {statistics.median(times):.2f} s", flush=True)


if __name__ == "__main__":
    main()
