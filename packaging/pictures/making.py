"""From the sample outcrop to the pictures of the documents: the demo, the window, the report."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from pictures import layers
from pictures.window import ACTS
from tests.benchmarks.window_journey import on_a_screen

ROOT = Path(__file__).resolve().parents[2]
STAGE = Path(tempfile.gettempdir()) / "vomstudio-pictures"
PARTS = ("layers", "sheets", *ACTS, "report")
LAYERS = "layers.svg"
PHOTOS = "beach cliff"
WIDEST = 1400
"""Pixels; what is wider is made smaller."""
QUALITIES = range(84, 40, -4)
"""Of WebP: the best with which a picture stays below the size."""
LARGEST_BYTES = 150_000
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PAGE = (1100, 1250)
"""Pixels of the report's first page, width and height."""


def make_pictures(folder: Path, only: str | None = None) -> int:
    """Make all pictures, or one part of them; the exit code."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = PARTS if only is None else (only,)
    if "layers" in parts:
        (folder / LAYERS).write_text(layers.drawn(), "utf-8")
    shutil.rmtree(STAGE, ignore_errors=True)
    taken = STAGE / "taken"
    taken.mkdir(parents=True)
    try:
        _prepare(set(parts))
        for part in parts:
            code = _take(part, taken)
            if code:
                print(f"the part {part} ended with {code}", file=sys.stderr)
                return code
        for picture in sorted(taken.glob("*.png")):
            _keep(picture, folder / f"{picture.stem}.webp")
    finally:
        shutil.rmtree(STAGE, ignore_errors=True)
    return 0


def _prepare(parts: set[str]) -> None:
    """What the parts show: the sample's photos, and all that the demo makes."""
    sample = ROOT / "resources" / "sample"
    photos = STAGE / PHOTOS
    shutil.copytree(sample / "photos", photos)
    for name in ("control.csv", "marks.csv"):
        shutil.copy(sample / name, photos)
    if parts & {"sheets", "measured", "report"}:
        finished = [] if "report" in parts else ["--without-photos"]
        run = [sys.executable, "-P", "-m", "vomstudio", "demo", "-o", "demo", *finished]
        subprocess.run(run, cwd=STAGE, check=True, stdout=subprocess.DEVNULL)


def _take(part: str, taken: Path) -> int:
    demo = STAGE / "demo"
    if part == "sheets":
        shutil.copy(demo / "net.png", taken / "net.png")
        shutil.copy(demo / "ortho_sheet.png", taken / "orthophoto_sheet.png")
    if part == "report":
        return _photograph(demo / "photos" / "report.html", taken / "report.png")
    if part in ACTS:
        script = str(Path(__file__).with_name("window.py"))
        opened = {"measured": demo / "sample.vom", "photos": STAGE / PHOTOS}.get(part)
        words = [] if opened is None else [str(opened)]
        return on_a_screen([script, str(taken), part, *words], STAGE, ROOT)
    return 0


def _photograph(page: Path, picture: Path) -> int:
    """The beginning of an HTML page, as a browser shows it."""
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if browser is None:
        print(f"no browser for the report: install one of {', '.join(BROWSERS)}", file=sys.stderr)
        return 2
    size = ",".join(map(str, PAGE))
    words = [
        browser,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        f"--window-size={size}",
        f"--screenshot={picture}",
        page.as_uri(),
    ]
    quiet = subprocess.DEVNULL
    return subprocess.run(words, cwd=STAGE, stdout=quiet, stderr=quiet).returncode


def _keep(taken: Path, kept: Path) -> None:
    from PIL import Image

    with Image.open(taken, formats=["PNG"]) as image:
        picture = image.convert("RGB")
    if picture.width > WIDEST:
        height = round(picture.height * WIDEST / picture.width)
        picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
    for quality in QUALITIES:
        picture.save(kept, "WEBP", quality=quality, method=6)
        if kept.stat().st_size <= LARGEST_BYTES:
            break
    print(f"{kept.name}: {kept.stat().st_size / 1000:.0f} kB", flush=True)
