"""How long small commands take as whole processes, over `import numpy` in the same run, a model of
a million triangles beside other programs, and two commands beside scripts of the same libraries.

    python -m tests.benchmarks.bench_commands [--runs 15] [--dir FOLDER] [--peer-python PYTHON]

The scripts are mplstereonet's contours of 10,000 poles, and LAZ to LAS by laspy.

Runs are interleaved, so that what else the machine does falls on all alike; processor seconds stand
beside wall seconds. Bytecode is kept, as it is for a user, and the first round, which writes it and
compiles kernels that were never used, is not counted. The model is that of bench_load without its
textures being decoded: `info` of it, CloudCompare's command line (which decodes them) and pymeshlab
(GPL, so only run, in the environment of --peer-python) each load it as a whole process.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.benchmarks.bench_load import ROOT, cloudcompare, make_obj, make_texture, medians, run
from vomstudio.cli import main as vomstudio

WANTED_OVER_NUMPY = 3.2
WANTED_OVER_CLOUDCOMPARE = 0.2
WANTED_OVER_PYMESHLAB = 0.6
WANTED_OVER_MPLSTEREONET = 0.5
WANTED_OVER_LASPY = 1.0
LASPY = "import laspy, sys; laspy.read(sys.argv[1]).write(sys.argv[2])"
MPLSTEREONET = """
import sys
import matplotlib
matplotlib.use("Agg")
import mplstereonet
import numpy as np
azimuth, dip = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1).T
figure, axes = mplstereonet.subplots()
axes.density_contourf(azimuth - 90.0, dip.copy(), method="exponential_kamb")
axes.pole(azimuth - 90.0, dip.copy(), "o", markersize=3)
figure.savefig(sys.argv[2])
"""
PYMESHLAB = "import pymeshlab, sys; pymeshlab.MeshSet().load_new_mesh(sys.argv[1])"
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
PLY = (
    "ply\nformat {}\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
)
COMMANDS = (
    "--version",
    "info two.obj",
    "info ascii.ply",
    "info binary.ply",
    "info two.stl",
    "info two.glb",
    "info points.csv",
    "info points.xyz",
    "info points.las",
    "info points.laz",
    "fit traces.csv --by id",
    "stats planes.csv",
    "fold planes.csv",
    "stereonet planes.csv -o net.svg --force",
    "convert two.obj out.ply --force",
)

MeasuredValue = dict[str, list[tuple[float, float]]]


def make_small_files(folder: Path) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    faces = [[0, 1, 2], [0, 2, 3]]
    (folder / "two.obj").write_text(OBJ)
    rows = [*(" ".join(map(str, row)) for row in corners), *(f"3 {a} {b} {c}" for a, b, c in faces)]
    (folder / "ascii.ply").write_text(PLY.format("ascii 1.0") + "\n".join(rows) + "\n")
    lists = b"".join(b"\x03" + np.array(face, "<i4").tobytes() for face in faces)
    head = PLY.format("binary_little_endian 1.0").encode()
    (folder / "binary.ply").write_bytes(head + corners.tobytes() + lists)
    facets = np.zeros(2, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    facets["corners"] = corners[faces]
    (folder / "two.stl").write_bytes(bytes(80) + b"\x02\0\0\0" + facets.tobytes())
    points = [(i, i * i % 7, i % 3) for i in range(20)]
    (folder / "points.xyz").write_text("".join(f"{x} {y} {z}\n" for x, y, z in points))
    (folder / "points.csv").write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in points))
    (folder / "traces.csv").write_text(
        "id,x,y,z\n" + "".join(f"{x // 10},{x},{y},{z}\n" for x, y, z in points)
    )
    (folder / "planes.csv").write_text(
        "dip_direction,dip\n" + "".join(f"{100 + x},{30 + y}\n" for x, y, _ in points)
    )
    for name in ("two.glb", "points.las", "points.laz"):
        source = folder / ("two.obj" if name == "two.glb" else "points.xyz")
        assert vomstudio(["convert", str(source), str(folder / name), "--force"]) == 0


def interleaved(cases: dict[str, Callable[[], tuple[float, float]]], runs: int) -> MeasuredValue:
    """Wall and processor seconds of each; one round before is not counted."""
    found: MeasuredValue = {name: [] for name in cases}
    for count in range(runs + 1):
        for name, measure in cases.items():
            seconds = measure()
            if count:
                found[name].append(seconds)
    return found


def process(words: list[str]) -> Callable[[], tuple[float, float]]:
    return lambda: run(words)[:2]


def small_commands(runs: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_small_files(folder)
        files = {file.name: str(file) for file in folder.iterdir()}
        cases = {"import numpy": process([sys.executable, "-c", "import numpy"])}
        for command in COMMANDS:
            words = [
                files.get(word, str(folder / word) if "." in word else word)
                for word in command.split()
            ]
            cases[command] = process([sys.executable, "-m", "vomstudio", *words])
        found = interleaved(cases, runs)
    numpy, numpy_cpu = medians(found["import numpy"])
    print(f"{'':40s} wall s  over numpy    CPU s  over numpy")
    for command, measured in found.items():
        wall, cpu = medians(measured)
        wanted = f"; wanted {WANTED_OVER_NUMPY}" if command == "info two.obj" else ""
        over = f"{wall / numpy:10.2f}   {cpu:6.3f}  {cpu / numpy_cpu:10.2f}"
        print(f"{command:40s} {wall:6.3f}  {over}{wanted}")


def beside_scripts(runs: int) -> None:
    """Contours of 10,000 poles and LAZ to LAS, each beside a script; and the growth of both."""
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for count in (2_500, 10_000, 40_000):
            table, points = folder / f"{count}.csv", folder / f"{count}.laz"
            normals = rng.normal([1.0, 2.0, 4.0], 1.0, (count, 3))
            azimuth = np.degrees(np.arctan2(normals[:, 0], normals[:, 1])) % 360.0
            dip = np.degrees(np.arctan2(np.hypot(*normals[:, :2].T), np.abs(normals[:, 2])))
            rows = "\n".join(f"{a:.2f},{d:.2f}" for a, d in zip(azimuth, dip, strict=True))
            table.write_text(f"dip_direction,dip\n{rows}\n")
            write_laz(points, 100 * count)
            picture, las = folder / "net.png", folder / "points.las"
            contour = ["stereonet", str(table), "-o", str(picture), "--force"]
            contour += ["--contour", "exponential_kamb"]
            convert = ["convert", str(points), str(las), "--force"]
            cases = {
                "stereonet": process([sys.executable, "-m", "vomstudio", *contour]),
                "mplstereonet": process(
                    [sys.executable, "-c", MPLSTEREONET, str(table), str(picture)]
                ),
                "convert": process([sys.executable, "-m", "vomstudio", *convert]),
                "laspy": process([sys.executable, "-c", LASPY, str(points), str(las)]),
            }
            cpu = {each: medians(m)[1] for each, m in interleaved(cases, runs).items()}
            print(
                f"{count:>6,} poles contoured {cpu['stereonet']:.2f} s (CPU),"
                f" {cpu['stereonet'] / cpu['mplstereonet']:.2f} of mplstereonet;"
                f" wanted {WANTED_OVER_MPLSTEREONET} of 10,000\n"
                f"{100 * count:>9,} points of LAZ to LAS {cpu['convert']:.2f} s (CPU),"
                f" {cpu['convert'] / cpu['laspy']:.2f} of laspy; wanted {WANTED_OVER_LASPY}",
                flush=True,
            )


def write_laz(path: Path, count: int) -> None:
    """Write a coloured cloud with intensity and classes."""
    import laspy

    rng = np.random.default_rng(0)
    header = laspy.LasHeader(version="1.4", point_format=7)
    header.scales, header.offsets = [0.001] * 3, [576_000.0, 5_188_000.0, 0.0]
    cloud = laspy.LasData(header)
    steps = np.cumsum(rng.normal(0.0, 0.01, (count, 2)), axis=0)
    cloud.x, cloud.y = 576_700.0 + steps[:, 0], 5_188_200.0 + steps[:, 1]
    cloud.z = 200.0 + rng.normal(0.0, 1.0, count)
    cloud.red, cloud.green, cloud.blue = rng.integers(0, 256, (3, count), dtype=np.uint16) * 257
    cloud.intensity = rng.integers(0, 60_000, count).astype(np.uint16)
    cloud.classification = rng.integers(0, 9, count).astype(np.uint8)
    cloud.write(path)


def million_triangles(folder: Path, runs: int, peer_python: str | None) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    model = folder / "cliff_1M.obj"
    for k in range(4):
        make_texture(folder / f"texture_{k}.jpg", 4096, k)
    make_obj(model, 1_000_000)
    cases = {"ours": process([sys.executable, "-m", "vomstudio", "info", str(model)])}
    wanted = {}
    if shutil.which("CloudCompare") and shutil.which("xvfb-run"):
        cases["CloudCompare"] = lambda: cloudcompare(model)
        wanted["CloudCompare"] = WANTED_OVER_CLOUDCOMPARE
    else:
        print("CloudCompare or xvfb-run is not installed: skipped")
    if peer_python:
        cases["pymeshlab"] = process([peer_python, "-c", PYMESHLAB, str(model)])
        wanted["pymeshlab"] = WANTED_OVER_PYMESHLAB
    else:
        print("pymeshlab: no --peer-python given, skipped")
    found = interleaved(cases, runs)
    wall, cpu = medians(found["ours"])
    print(f"OBJ of 1 M triangles, whole process: {wall:.2f} s (CPU {cpu:.2f})")
    for peer, most in wanted.items():
        other, other_cpu = medians(found[peer])
        print(
            f"  {peer} {other:.2f} s (CPU {other_cpu:.2f}): ours is {wall / other:.2f} of it"
            f" (CPU {cpu / other_cpu:.2f}); wanted at most {most}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--dir", type=Path, default=ROOT / "tests" / "benchmarks" / "out")
    parser.add_argument("--peer-python", help="a Python that has pymeshlab")
    options = parser.parse_args()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    print(f"{os.cpu_count()} processors, load before: {os.getloadavg()[0]:.1f}")
    small_commands(options.runs)
    beside_scripts(max(3, options.runs // 3))
    million_triangles(options.dir, max(3, options.runs // 3), options.peer_python)


if __name__ == "__main__":
    main()
