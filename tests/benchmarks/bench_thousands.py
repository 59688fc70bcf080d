"""What thousands of features cost: in the whole window, and without one.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.benchmarks.bench_thousands [--window 3000 5000]
        [--headless 3000 5000 50000]

Each size is a process of its own, with the settings of a new user. The traces, of 8 to 30 vertices,
lie on a cliff of 100 x 60 m that this script makes; they were added one by one, as a user adds
them.

In the window: the project is opened; a trace is selected, changed, deleted, brought back, added,
the table is filtered, every feature is selected, half of them are selected, changed, deleted, and
the view is dragged without and with this selection. Each row is of one gesture that is repeated
alone; what undoes it is not counted. Of each gesture: milliseconds until all that it brought about
has been painted, those that the processor spent on it in the window's thread (on a machine that
others use too the first say little), and the longest gap between beats of a 5 ms timer until the
window is at rest (the net is drawn anew after the gesture itself). Of a drag: the 95th percentile,
the median and the maximum of its steps, and what the processor spent on a step, in the window's
thread and in all of them (a software renderer draws in others). Last the memory that the process
holds. `--profile FOLDER` writes a profile of each gesture.

Without a window: the milliseconds of adding a trace to so many, and the seconds of
`vomstudio export --to csv`. With several sizes, the exponent of growth of each row is printed: that
of the power law through all sizes, of the time and of the longest gap.
"""

from __future__ import annotations

import argparse
import cProfile
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from tests.kernel_cache import share_kernel_cache

SIZE = (1400, 900)
WANTED = {
    "open": "gap 100 ms, 1.5 s",
    "select": "50 ms",
    "change": "50 ms",
    "delete": "50 ms",
    "every": "100 ms",
    "set half": "300 ms, gap 100 ms",
    "drag": "50 ms",
    "drag half": "50 ms",
}
FILTERS = ("dip>30", "type:joint", "J2", "quality:good", "-bedding", "")
REPEATS, FEW = 9, 5
BULK = 2000
"""Above so many the traces come in one edit: without a window it makes no difference."""


# --- what is measured on -------------------------------------------------------------------------
def cliff(folder: Path) -> Path:
    """A rough cliff of 100 x 60 m with 120,000 triangles, in a file."""
    x, z = np.meshgrid(np.linspace(0.0, 100.0, 317), np.linspace(0.0, 60.0, 191))
    vertices = np.stack([x, depth(x, z), z], -1).reshape(-1, 3)
    wide = x.shape[1]
    a = (np.arange(x.shape[0] - 1)[:, None] * wide + np.arange(wide - 1)).ravel()
    faces = np.zeros(2 * len(a), [("n", "u1"), ("ids", "<i4", 3)])
    faces["n"] = 3
    faces["ids"] = np.concatenate(
        [np.stack([a, a + 1, a + wide + 1], 1), np.stack([a, a + wide + 1, a + wide], 1)]
    )
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path = folder / "cliff.ply"
    path.write_bytes(head.encode() + vertices.astype("<f8").tobytes() + faces.tobytes())
    return path


def depth(x: Any, z: Any) -> Any:
    y = 2.0 * np.sin(x / 3.0) * np.cos(z / 5.0) + 0.4 * np.sin(3.1 * x + 1.7 * z)
    return y + 0.05 * np.sin(40.0 * x) * np.sin(37.0 * z) + 0.2 * z


def trace(number: int, model: Any) -> Any:
    """A line across the cliff where a plane of some attitude meets it."""
    from vomstudio.project.kinds.trace import Trace

    rng = np.random.default_rng(number)
    count = int(rng.integers(8, 31))
    x = rng.uniform(0.0, 90.0) + np.sort(rng.uniform(0.0, 6.0, count))
    z = np.clip(rng.uniform(5.0, 55.0) + 0.3 * (x - x[0]) + 0.4 * np.sin(x), 0.0, 60.0)
    points = np.stack([x, depth(x, z), z + rng.normal(0.0, 0.01, count)], -1)
    kinds = ("bedding", "joint", "fault")
    return Trace(
        f"trace-{number:06d}",
        "",
        kinds[number % 3],
        model.id,
        model.content_hash,
        tuple(map(tuple, points.tolist())),
        resolution=0.3,
        outcrop_normal=(0.1, -0.97, 0.22),
        set_name=("", "J1", "J2")[number % 3],
    )


def make_project(folder: Path, count: int) -> Path:
    from vomstudio.io.gate.frame_options import FrameOptions
    from vomstudio.project import edits
    from vomstudio.project.edit import change
    from vomstudio.studio.headless_project import HeadlessProject

    path = folder / f"{count}.vom"
    head = HeadlessProject.create(path)
    model = head.add_model(cliff(folder), FrameOptions(crs="EPSG:32633")).model
    session = head.session
    if count <= 2 * BULK + 1000:
        for number in range(count):
            session.apply(edits.add_trace(session.records, trace(number, model)))
    else:
        from dataclasses import replace

        made = [replace(trace(i, model), name=f"B{i + 1:02d}") for i in range(count)]
        session.apply(change(session.records, f"Add {count} traces", {t.id: t for t in made}))
    head.save()
    head.close()
    return path


# --- in the window -------------------------------------------------------------------------------
class Gestures:
    """Times what is done in a window."""

    def __init__(self, window: Any, app: Any, profiles: Path | None) -> None:
        from tests.benchmarks.bench_viewport import Heartbeat

        self.window, self.app, self.profiles = window, app, profiles
        self.heart = Heartbeat()

    def rest(self) -> None:
        """Until nothing has happened for a while."""
        quiet = time.perf_counter()
        while time.perf_counter() - quiet < 0.5:
            begun = time.perf_counter()
            self.app.processEvents()
            if time.perf_counter() - begun > 0.004:
                quiet = time.perf_counter()
            time.sleep(0.0005)

    def time(
        self, name: str, do: Callable[[int], object], repeats: int = REPEATS, undo: Any = None
    ) -> None:
        taken, busy, gaps = [], [], []
        profile = cProfile.Profile() if self.profiles else None
        for k in range(repeats):
            self.heart.restart()
            with profile or nullcontext():
                begun, used = time.perf_counter(), time.thread_time()
                do(k)
                self.app.processEvents()
                taken.append(time.perf_counter() - begun)
                busy.append(time.thread_time() - used)
                self.rest()
            gaps.append(max(self.heart.gaps))
            if undo is not None:
                undo(k)
                self.rest()
        if profile is not None and self.profiles is not None:
            profile.dump_stats(self.profiles / f"{name}.prof")
        t, u, g = (1e3 * np.array(values) for values in (taken, busy, gaps))
        wanted = f"   wanted: {WANTED[name]}" if name in WANTED else ""
        print(
            f"  {name:18s} {np.median(t):7.1f} ms (processor {np.median(u):6.1f}),"
            f" longest {t.max():7.1f} ({u.max():6.1f});"
            f" longest gap {np.median(g):7.1f}, at the most {g.max():7.1f}{wanted}",
            flush=True,
        )

    def drag(self, name: str, steps: int = 40) -> None:
        """Time the steps of a drag over the viewport."""
        from tests.benchmarks.bench_viewport import drag

        self.heart.restart()
        profile = cProfile.Profile() if self.profiles else None
        used, all_used = time.thread_time(), time.process_time()
        with profile or nullcontext():
            times = 1e3 * np.array(drag(self.app, self.window.viewport, steps))
        used, all_used = time.thread_time() - used, time.process_time() - all_used
        self.rest()
        if profile is not None and self.profiles is not None:
            profile.dump_stats(self.profiles / f"{name}.prof")
        each = 1e3 / (steps + 2)
        print(
            f"  {name:18s} {np.quantile(times, 0.95):7.1f} ms at 95 % of the steps"
            f" (processor {each * used:6.1f}, all threads {each * all_used:6.1f}),"
            f" half {np.median(times):7.1f}, longest {times.max():7.1f};"
            f" longest gap {1e3 * max(self.heart.gaps):7.1f}   wanted: {WANTED[name]}",
            flush=True,
        )


def in_window(path: Path, profiles: Path | None) -> None:
    from PySide6.QtWidgets import QApplication

    from tests import driver
    from tests.benchmarks.bench_viewport import memory_mb
    from vomstudio.project import edits

    app = QApplication([])
    window = driver.make_window()
    window.resize(*SIZE)
    gestures = Gestures(window, app, profiles)
    gestures.rest()
    before = memory_mb()
    studio = window.studio

    gestures.heart.restart()
    profile = cProfile.Profile() if profiles else None
    with profile or nullcontext():
        begun, used = time.perf_counter(), time.thread_time()
        window.open_path(path)
        while not shown_whole(window):
            app.processEvents()
            time.sleep(0.0005)
        whole, used = time.perf_counter() - begun, time.thread_time() - used
        gestures.rest()
    if profile is not None and profiles is not None:
        profile.dump_stats(profiles / "open.prof")
    driver.settled(window)
    gaps = 1e3 * np.array(gestures.heart.gaps)
    features = studio.session.features()
    print(f"== {len(features):,} traces in the window")
    print(
        f"  open     {whole:7.2f} s (processor {used:5.2f}); longest gap"
        f" {gaps.max():7.1f} ms, {(gaps > 100).sum()} over 100 ms   wanted: {WANTED['open']}"
    )
    gestures.rest()
    ids = [f.id for f in features]

    def chosen(k: int) -> list[str]:
        return [ids[(k * 997) % len(ids)]]

    gestures.time("select", lambda k: studio.selection.set(chosen(k)))
    gestures.time(
        "change",
        lambda k: studio.attempt(edits.set_attributes, chosen(k), set_name=f"S{k}"),
    )
    gestures.time("move", lambda k: moved(studio, chosen(k)[0], k))

    def delete(k: int) -> None:
        studio.selection.set(chosen(k))
        gestures.rest()

    def deleted(k: int) -> None:
        studio.workspace.delete_selected()

    for k in range(1):
        delete(k)
    gestures.time(
        "delete", deleted, REPEATS, lambda k: (studio.workspace.history.undo(), delete(k + 1))
    )
    gestures.time(
        "undo",
        lambda k: studio.workspace.history.undo(),
        undo=lambda k: studio.attempt(edits.set_attributes, chosen(k), notes=f"note {k}"),
    )
    model = next(iter(studio.models))
    record = studio.records[model]
    gestures.time("add", lambda k: studio.attempt(edits.add_trace, trace(1_000_000 + k, record)))
    for text in FILTERS:
        for name, field in (("filter", window.table._filter), ("tree", window.tree.filter)):
            other = "" if text else "dip>30"
            field.setText(other)
            gestures.rest()
            gestures.time(
                f"{name} {text or 'off'}",
                lambda _, field=field, text=text: field.setText(text),
                FEW,
                lambda _, field=field, other=other: field.setText(other),
            )
            field.setText("")
    gestures.time(
        "every", lambda _: studio.selection.set(ids), FEW, lambda _: studio.selection.set(ids[:1])
    )
    gestures.time(
        "hide",
        lambda _: studio.set_visible(["joint"], False),
        FEW,
        lambda _: studio.set_visible(["joint"], True),
    )
    studio.selection.set([])
    gestures.rest()
    gestures.drag("drag")
    half, history = ids[::2], studio.workspace.history
    gestures.time(
        "half", lambda _: studio.selection.set(half), FEW, lambda _: studio.selection.set([])
    )
    studio.selection.set(half)
    gestures.rest()
    gestures.drag("drag half")
    gestures.time(
        "set half", lambda k: studio.attempt(edits.set_attributes, half, set_name=f"H{k}"), FEW
    )
    gestures.time(
        "undo half",
        lambda _: history.undo(),
        FEW,
        lambda k: studio.attempt(edits.set_attributes, half, set_name=f"I{k}"),
    )

    def delete_half(_: int) -> None:
        studio.workspace.delete_selected()

    def restore_half(_: int) -> None:
        history.undo()
        studio.selection.set(half)

    gestures.time("delete half", delete_half, FEW, restore_half)
    print(f"  memory     {before:.0f} MB before, {memory_mb():.0f} MB after", flush=True)
    driver.dismiss(window)


def shown_whole(window: Any) -> bool:
    """Every feature of the project stands in table, tree and outcrop."""
    features = window.studio.session.features()
    return (
        bool(features)
        and window.table.model.rowCount() == len(features)
        and all(window.tree._items.get(f.id) is not None for f in features[-1:])
        and len(window.viewport.features.drawings) == len(features)
    )


def moved(studio: Any, id_: str, k: int) -> None:
    """Another place for one vertex of a trace, as its handle gives it."""
    from vomstudio.project import edits

    old = studio.records[id_]
    x, y, z = old.vertices[1]
    studio.attempt(
        edits.set_vertices,
        id_,
        (old.vertices[0], (x, y, z + 0.001 * (k + 1)), *old.vertices[2:]),
        resolution=old.resolution,
        outcrop_normal=old.outcrop_normal,
    )


# --- without a window ----------------------------------------------------------------------------
def headless(path: Path) -> None:
    from vomstudio.project import edits
    from vomstudio.studio.headless_project import HeadlessProject

    begun, used = time.perf_counter(), time.process_time()
    with HeadlessProject.open(path) as head:
        session = head.session
        whole, used = time.perf_counter() - begun, time.process_time() - used
        print(f"== {len(session.features()):,} traces without a window")
        print(f"  open     {whole:7.2f} s (processor {used:6.2f})")
        model = head.find_model(None)
        taken = []
        for k in range(25):
            new = trace(1_000_000 + k, model)
            begun, used = time.perf_counter(), time.process_time()
            session.apply(edits.add_trace(session.records, new))
            taken.append((time.perf_counter() - begun, time.process_time() - used))
        t, u = 1e3 * np.array(taken[1:]).T
        print(
            f"  add      {np.median(t):7.2f} ms (processor {np.median(u):5.2f}),"
            f" longest {t.max():7.2f} ({u.max():5.2f})   wanted: 5 ms"
        )
        head.save()
    out = path.with_suffix(".csv")
    begun, used = time.perf_counter(), os.times()
    subprocess.run(
        [
            sys.executable,
            "-m",
            "vomstudio",
            "export",
            str(path),
            "--to",
            "csv",
            "-o",
            str(out),
            "--force",
        ],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    whole, now = time.perf_counter() - begun, os.times()
    busy = now.children_user + now.children_system - used.children_user - used.children_system
    print(f"  csv      {whole:7.2f} s (processor {busy:6.2f})   wanted: 6 s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--window", type=int, nargs="*", default=[3000, 5000])
    parser.add_argument("--headless", type=int, nargs="*", default=[3000, 5000, 50_000])
    parser.add_argument("--profile", type=Path, help="a folder for profiles of the gestures")
    parser.add_argument("--keep", type=Path, help="a folder for the projects, to be used again")
    parser.add_argument("--inside", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inside:
        what, path = options.inside
        if what == "window":
            in_window(Path(path), options.profile)
        else:
            headless(Path(path))
        return
    if options.profile:
        options.profile.mkdir(parents=True, exist_ok=True)
    sizes = [("window", n) for n in options.window] + [("headless", n) for n in options.headless]
    rows = []
    for what, count in sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            kept = options.keep and options.keep / f"{count}.vom"
            if kept and not kept.is_dir():
                options.keep.mkdir(parents=True, exist_ok=True)
                make_project(options.keep, count)
            path = kept if kept else make_project(folder, count)
            if kept:
                path = folder / kept.name
                shutil.copytree(kept, path)
                shutil.copy(options.keep / "cliff.ply", folder)
            words = ["--profile", str(options.profile)] if options.profile else []
            rows.append(run(folder, [*words, "--inside", what, str(path)]))
    print_growth(sizes, rows)


def run(folder: Path, words: list[str]) -> dict[str, float]:
    """Run this script in a fresh process, with the settings of a new user, and return its rows."""
    share_kernel_cache()
    home = {
        name: str(folder / "user" / name.lower())
        for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")
    }
    environment = {**os.environ, **home, "VOMSTUDIO_SETTINGS": str(folder / "settings.toml")}
    child = subprocess.Popen(
        [sys.executable, "-m", "tests.benchmarks.bench_thousands", *words],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    rows = {}
    for line in child.stdout or ():
        print(line, end="", flush=True)
        if found := re.match(r"  (.{8,18}?) +([0-9.]+) (?:ms|s)\b", line):
            rows[found[1].strip()] = float(found[2])
            if gap := re.search(r"longest gap +([0-9.]+)", line):
                rows[f"{found[1].strip()}, gap"] = float(gap[1])
    if child.wait():
        raise SystemExit(child.returncode)
    return rows


def print_growth(sizes: list[tuple[str, int]], rows: list[dict[str, float]]) -> None:
    """Print the exponent of the power law with which each row grows with the features."""
    for kind in ("window", "headless"):
        known = [(n, row) for (what, n), row in zip(sizes, rows, strict=True) if what == kind]
        if len(known) < 2:
            continue
        counts = np.log([n for n, _ in known])
        print(
            f"== growth over {', '.join(f'{n:,}' for n, _ in known)} features ({kind}), exponents"
        )
        for name in known[0][1]:
            values = np.array([row.get(name, 0.0) for _, row in known])
            if (values > 0.0).all():
                exponent = np.polyfit(counts, np.log(values), 1)[0]
                print(f"  {name:24s} {exponent:6.2f}{'   OVER 1.1' if exponent > 1.1 else ''}")


if __name__ == "__main__":
    main()
