"""No screen, no OpenGL, a library that is missing: a sentence with the remedy, and code 2."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.messages import shown_codes, shown_values
from tests.tiers import first_in_default_tier
from vomstudio.core.failures.missing_libraries import missing_library

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="about X11")


def window(tmp_path: Path, **extra: str | None) -> subprocess.CompletedProcess[str]:
    values = {**os.environ, "XDG_STATE_HOME": str(tmp_path), **extra}
    return subprocess.run(
        [sys.executable, "-P", "-m", "vomstudio"],
        env={name: value for name, value in values.items() if value is not None},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=Path(__file__).parents[2],
    )


@pytest.mark.full
@pytest.mark.parametrize("display", [None, "", ":7777"])
def test_missing_screen_is_reported(tmp_path: Path, display: str | None) -> None:
    done = window(tmp_path, DISPLAY=display, WAYLAND_DISPLAY=None, QT_QPA_PLATFORM=None)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    code = "screen.unreachable" if display else "screen.missing"
    assert shown_codes(done.stderr) == {code}


@pytest.mark.full  # the window waits ten seconds for another driver
@pytest.mark.skipif(not os.environ.get("DISPLAY"), reason="needs a screen")
def test_outdated_opengl_is_reported(tmp_path: Path) -> None:
    done = window(
        tmp_path, QT_QPA_PLATFORM="xcb", LIBGL_ALWAYS_SOFTWARE="1", MESA_GL_VERSION_OVERRIDE="2.1"
    )
    assert done.returncode == 2, done.stderr
    versions = {"version": "2.1", "needed": "3.2"}
    assert shown_values(done.stderr, "screen.old-opengl") == versions


def test_missing_library_is_reported_with_its_package() -> None:
    finding = missing_library(ImportError("libEGL.so.1: cannot open shared object file"))
    assert finding is not None
    assert finding.code == "program.package-missing"
    assert finding.values == {"library": "libEGL.so.1", "package": "libegl1"}
    for message, values in (
        ("libusb-1.0.so.0: file too short", {"package": "libusb-1.0-0"}),
        ("liboddity.so.3: no version information", {"library": "liboddity.so.3"}),
    ):
        finding = missing_library(message)
        assert finding is not None
        assert finding.values.items() >= values.items(), finding
    assert missing_library(ImportError("No module named 'pye57'")) is None


@pytest.mark.skipif(not os.environ.get("DISPLAY"), reason="needs a screen")
@pytest.mark.parametrize(
    "name", ["libEGL.so.1", "libxcb-cursor.so.0", "libxcb-icccm.so.4", "libGL.so.1"]
)
def test_damaged_library_is_detected_before_the_window_opens(tmp_path: Path, name: str) -> None:
    """The loader finds the damaged one first."""
    (tmp_path / name).write_text("cut short")
    done = window(tmp_path, QT_QPA_PLATFORM="xcb", LD_LIBRARY_PATH=str(tmp_path))
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert name in done.stderr
    assert "apt install" in done.stderr


@pytest.mark.parametrize(
    "name", first_in_default_tier(["libEGL.so.1", "libGL.so.1", "libX11.so.6", "libxcb.so.1"], 1)
)
def test_commands_run_without_screen_and_display_libraries(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("cut short")
    folder = Path(__file__).parents[1] / "specimens"
    words = ["ortho", str(folder / "boulder.ply"), "--trend", "0", "--plunge", "90"]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "vomstudio", *words, "--gsd", "0.2", "-o", "map.tif"],
        env={**os.environ, "DISPLAY": "", "LD_LIBRARY_PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
