"""What large clouds cost in the whole window: stages and freezes.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.benchmarks.bench_clouds [--copc FILE] [--millions 50] [--laz FILE]

A COPC file of so many million made points is written to FILE where there is none (a rough cliff of
100 x 60 m, a minute for 50 million). Opening it in a fresh window: time to the first picture, to
the model itself, and to all that the view needs, longest gap of a 5 ms timer, then the same closer
by and back. Of a LAZ file: preview, data, shown, pickable, whole, and gaps over 60 ms with when
they were.
"""

from __future__ import annotations

import argparse
import os
import struct
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QApplication

from tests.kernel_cache import share_kernel_cache

ORIGIN = np.array([576_700.0, 5_188_100.0, 180.0])
NODE_POINTS = 50_000
SIDE = 128.0
CELLS = 128


def write_cliff(path: Path, points: int) -> None:
    """A COPC file node by node: level by level a thin even sample of the cliff, each level with
    four times the points of the one above, the last with what is left."""
    import laspy
    import lazrs

    from tests.io.models.copc_maker import header_bytes, write_pages

    header = laspy.LasHeader(version="1.4", point_format=7)
    header.scales, header.offsets = [0.001] * 3, ORIGIN
    vlr = lazrs.LazVlr.new_for_compression(7, 0, True)
    names = [(b"copc", 1, bytes(160)), (b"laszip encoded", 22204, bytes(vlr.record_data()))]
    from pyproj import CRS

    names.append((b"LASF_Projection", 2112, CRS.from_epsg(32615).to_wkt().encode() + b"\0"))
    points_at = 375 + sum(54 + len(content) for _, _, content in names)
    rng = np.random.default_rng(1)
    low = -np.array([14.0, SIDE / 2, 34.0])
    kind = laspy.PointFormat(7).dtype()
    weights = 4.0 ** np.arange(9)
    levels = next(k for k in range(1, 9) if (weights[:k] * NODE_POINTS * 0.47).sum() > points) - 1
    share = weights[: levels + 1] / weights[: levels + 1].sum()
    chunks = []
    with open(path, "w+b") as file:
        file.write(bytes(points_at))
        packer = lazrs.LasZipCompressor(file, vlr)
        packer.reserve_offset_to_chunk_table()
        for level in range(levels + 1):
            wanted = int(points * share[level])
            x, z = rng.random(wanted) * 100.0, rng.random(wanted) * 60.0
            y = 2.0 * np.sin(x / 3.0) * np.cos(z / 5.0) + 0.4 * np.sin(3.1 * x + 1.7 * z)
            raw = np.zeros(wanted, kind)
            place = np.stack([x, y, z], 1)
            for axis, name in enumerate("XYZ"):
                raw[name] = np.rint(place[:, axis] * 1000)
            raw["red"] = (120 + 60 * np.sin(x)).astype(np.uint16) << 8
            raw["green"] = (110 + 50 * np.cos(2 * z)).astype(np.uint16) << 8
            raw["blue"] = (100 + 40 * np.sin(x * z)).astype(np.uint16) << 8
            raw["intensity"] = rng.integers(1, 60000, wanted)
            cell = ((place - low) / (SIDE / 2**level)).astype(np.int64)
            code = (cell[:, 0] << 40) | (cell[:, 1] << 20) | cell[:, 2]
            order = np.argsort(code, kind="stable")
            starts = np.flatnonzero(np.r_[True, np.diff(code[order]) != 0])
            for first, last in zip(starts, [*starts[1:], wanted], strict=True):
                at = file.tell()
                packer.compress_many(np.frombuffer(raw[order[first:last]].tobytes(), np.uint8))
                packer.finish_current_chunk()
                key = np.array([level, *cell[order[first]]])
                chunks.append((key, at, file.tell() - at, int(last - first)))
        packer.done()
        file.seek(0, 2)
        evlr_at = file.tell()
        root_at, root_bytes = write_pages(file, chunks, 3)
        centre = ORIGIN + low + SIDE / 2
        info = struct.pack(
            "<5d2Q2d88x", *centre, SIDE / 2, SIDE / CELLS, root_at, root_bytes, 0.0, 0.0
        )
        names[0] = (b"copc", 1, info)
        total = sum(count for *_, count in chunks)
        sized = laspy.LasData(header)

        class Promise:
            def __init__(self) -> None:
                self.header, self.point_format = sized.header, sized.point_format
                self.points = range(total)

        file.seek(0)
        high = ORIGIN + [100.0, 2.4, 60.0]
        file.write(
            header_bytes(Promise(), points_at, len(names), evlr_at, ORIGIN - [0, 2.4, 0], high)
        )
        for user, number, content in names:
            file.write(struct.pack("<H16sHH32s", 0, user, number, len(content), b"") + content)


class Gaps:
    """Gaps of a 5 ms timer, with when they ended."""

    def __init__(self) -> None:
        self.timer = QTimer()
        self.timer.setTimerType(Qt.TimerType.PreciseTimer)
        self.timer.timeout.connect(self.beat)
        self.started = self.last = time.perf_counter()
        self.found: list[tuple[float, float]] = []
        self.timer.start(5)

    def beat(self) -> None:
        now = time.perf_counter()
        self.found.append((now - self.last, now - self.started))
        self.last = now

    def restart(self) -> None:
        self.found.clear()
        self.started = self.last = time.perf_counter()

    def report(self) -> str:
        longest = max((gap for gap, _ in self.found), default=0.0)
        late = [f"{gap * 1e3:.0f} at {at:.2f} s" for gap, at in self.found if gap > 0.06]
        over = sum(gap > 0.1 for gap, _ in self.found)
        return f"longest gap {longest * 1e3:.0f} ms, {over} over 100 ms ({', '.join(late)})"


def own_memory() -> float:
    """MB that are the process's own, without files that are mapped."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("RssAnon"):
            return float(line.split()[1]) / 1024.0
    return float("nan")


def pump(app: QApplication, seconds: float, until=lambda: False) -> float:  # type: ignore[no-untyped-def]
    started = time.perf_counter()
    while time.perf_counter() - started < seconds and not until():
        app.processEvents()
        time.sleep(0.0005)
    return time.perf_counter() - started


def run(app: QApplication, path: Path) -> None:
    from tests.driver import dismiss, make_window

    print(f"\n== {path.name}, {path.stat().st_size / 1e6:.0f} MB")
    window = make_window()
    pump(app, 3.0)
    view, studio = window.viewport, window.studio
    heart = Gaps()
    marks: dict[str, float] = {}
    started = time.perf_counter()

    def mark(name: str) -> None:
        marks.setdefault(name, time.perf_counter() - started)

    def stage(key: str, what: str) -> None:
        mark(
            "first picture"
            if key.startswith("preview:") and what == "shown"
            else what
            if not key.startswith("preview:")
            else "preview whole"
        )

    view.model_stage.connect(stage)
    studio.loader.previewed.connect(lambda *_: mark("preview read"))
    studio.model_loaded.connect(lambda *_: mark("data"))
    heart.restart()
    window.open_path(path)
    pump(app, 120.0, lambda: {"complete", "pickable"} <= marks.keys())
    print("stages        " + ", ".join(f"{k} {v:.2f} s" for k, v in marks.items()))
    print(f"gaps          {heart.report()}")
    scene = view.scene
    (model,) = (m for m in scene.models.values() if not m.model_id.startswith("preview:"))

    def settled() -> bool:
        return bool(view.is_still) and scene.nodes.is_settled

    def say(what: str, seconds: float) -> None:
        held = sum(p.elements for p in model.parts)
        drawn = sum(p.elements for p in model.parts if p.row in model.shown_rows)
        nodes = len(model.shown_rows)
        print(
            f"{what:13s} {seconds:.2f} s, {drawn:,} points of {nodes} nodes, {held:,} held, "
            f"{own_memory():.0f} MB, {heart.report()}"
        )

    say("whole view", pump(app, 60.0, settled))
    before = view.moves.camera_state()
    for k in range(3):
        heart.restart()
        hit = view.pick(view.width() * (0.3 + 0.2 * k), view.height() * 0.5)
        if hit is not None:
            for _ in range(6):
                view.camera.zoom(0.7, view.world_position(hit))
                view.moves.redraw()
                pump(app, 0.05)
        pump(app, 0.3)
        say("closer", pump(app, 60.0, settled) + 0.6)
        if shot := os.environ.get("SHOTS"):
            view.grab().save(f"{shot}/closer{k}.png")
        heart.restart()
        view.moves.set_camera_state(before)
        pump(app, 0.3)
        say("back", pump(app, 60.0, settled) + 0.3)
    if shot := os.environ.get("SHOTS"):
        view.grab().save(f"{shot}/back.png")
    heart.timer.stop()
    dismiss(window)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--copc", type=Path)
    parser.add_argument("--millions", type=float, default=50.0)
    parser.add_argument("--laz", type=Path)
    args = parser.parse_args()
    share_kernel_cache()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["VOMSTUDIO_SETTINGS"] = f"{folder}/settings.toml"
        for name in ("STATE", "CONFIG", "CACHE", "DATA"):
            os.environ[f"XDG_{name}_HOME"] = f"{folder}/{name.lower()}"
        app = QApplication.instance() or QApplication([])
        if args.copc is not None:
            if not args.copc.exists():
                print(f"writing {args.copc}")
                write_cliff(args.copc, int(args.millions * 1e6))
            run(app, args.copc)
        if args.laz is not None:
            run(app, args.laz)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
