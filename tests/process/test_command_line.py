"""The command line as scripts meet it: real processes, real descriptors."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.tiers import first_in_default_tier

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = [sys.executable, "-c", "import sys; from vomstudio.cli import main; sys.exit(main())"]
POINTS = "x,y,z,trace\n" + "".join(
    f"{x},{y},{0.5 * x + 0.1 * ((x * y) % 3)},層 é\n" for x in range(5) for y in range(5)
)

posix = pytest.mark.skipif(os.name != "posix", reason="about POSIX descriptors and signals")


def environment(**extra: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), **extra}


def run(*words: object, **options: Any) -> subprocess.CompletedProcess[bytes]:
    extra = options.pop("env", {})
    return subprocess.run(
        [*PROGRAM, *map(str, words)],
        stdout=options.pop("stdout", subprocess.PIPE),
        stderr=options.pop("stderr", subprocess.PIPE),
        env=environment(**extra),
        timeout=60,
        check=False,
        **options,
    )


@pytest.fixture
def points(tmp_path: Path) -> Path:
    path = tmp_path / "points.csv"
    path.write_text(POINTS, encoding="utf-8")
    return path


@pytest.mark.parametrize("locale", first_in_default_tier(["C", "C.UTF-8", "de_DE.ISO-8859-1"]))
def test_json_is_utf8_whatever_the_locale(points: Path, locale: str) -> None:
    done = run(
        "fit",
        points,
        "--by",
        "trace",
        "--json",
        env={"LC_ALL": locale, "LANG": locale, "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"},
    )
    assert done.returncode == 0
    assert json.loads(done.stdout.decode("utf-8"))["planes"][0]["id"] == "層 é"
    assert done.stdout.count(b"\n") == 1


@posix
def test_library_output_on_stdout_does_not_reach_the_json(points: Path) -> None:
    noisy = (
        "import os, sys, vomstudio.io.text.tables as t; old = t.read_points\n"
        "def noise(*a):\n"
        "    os.write(1, b'from C\\n'); print('from Python'); os.system('echo from a child')\n"
        "    return old(*a)\n"
        "t.read_points = noise\n"
        "from vomstudio.cli import main; sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", noisy, "fit", str(points), "--json"],
        capture_output=True,
        env=environment(),
        timeout=60,
        check=False,
    )
    assert done.returncode == 0
    assert json.loads(done.stdout)["planes"]
    for words in (b"from C", b"from Python", b"from a child"):
        assert words in done.stderr


@posix
def test_closed_reader_of_stdout_is_not_an_error(points: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = run("fit", points, "--json", stdout=writing)
    os.close(writing)
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr
    assert b"BrokenPipe" not in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_full_disk_behind_stdout_is_reported(points: Path) -> None:
    with open("/dev/full", "wb") as full:
        done = run("fit", points, "--json", stdout=full)
    assert done.returncode == 2
    assert b"disk is full" in done.stderr
    assert b"Traceback" not in done.stderr


@posix
@pytest.mark.parametrize("closed", first_in_default_tier(["1", "2", "0"]))
def test_closed_descriptor_does_not_crash(points: Path, closed: str) -> None:
    done = subprocess.run(
        ["sh", "-c", f'exec "$@" {closed}>&-', "sh", *PROGRAM, "fit", str(points), "--json"],
        capture_output=True,
        env=environment(),
        timeout=60,
        check=False,
    )
    assert done.returncode in (0, 2)
    assert b"Traceback" not in done.stderr
    if closed != "1":
        assert json.loads(done.stdout)["planes"]


@posix
def test_output_on_a_closed_stdout_does_not_reach_the_table(points: Path, tmp_path: Path) -> None:
    noisy = (
        "import os, sys, vomstudio.project.tables.orientation_table as t; old = t.plane_row\n"
        "def noise(*a, **k): os.write(1, b'noise'); return old(*a, **k)\n"
        "t.plane_row = noise\n"
        "from vomstudio.cli import main; sys.exit(main())"
    )
    target = tmp_path / "out.csv"
    command = [sys.executable, "-c", noisy, "fit", str(points), "-o", str(target)]
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" 1>&-', "sh", *command],
        stderr=subprocess.PIPE,
        env=environment(),
        timeout=60,
        check=False,
    )
    assert done.returncode == 0
    assert target.read_bytes().startswith(b"# VOM Studio")
    assert b"noise" not in target.read_bytes()


@posix
@pytest.mark.parametrize("asked", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_interruption_exits_with_130_and_one_line(tmp_path: Path, asked: str) -> None:
    pipe = tmp_path / "slow"
    os.mkfifo(pipe)
    process = subprocess.Popen(
        [*PROGRAM, "fit", str(pipe), "-o", str(tmp_path / "out.csv")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(),
        # Whoever starts the tests in the background hands down an ignored SIGINT, and nohup an
        # ignored SIGHUP.
        preexec_fn=lambda: [
            signal.signal(
                each, signal.SIG_DFL if each != signal.SIGINT else signal.default_int_handler
            )
            for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        ],
    )
    try:
        # Opening for writing waits until the command has opened the pipe to read.
        with open(pipe, "wb") as writer:
            writer.write(b"0 0 0\n")
            writer.flush()
            time.sleep(0.3)  # let it get from opening to reading, where a signal is seen
            process.send_signal(getattr(signal, asked))
            out, err = process.communicate(timeout=20)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 130
    assert out == b""
    assert err == b"vomstudio: Cancelled.\n"
    assert [p.name for p in tmp_path.iterdir()] == ["slow"]


@posix
def test_points_are_read_from_a_pipe() -> None:
    done = run("fit", "/dev/stdin", "--json", input=POINTS.encode())
    assert done.returncode == 0
    assert json.loads(done.stdout)["planes"][0]["n_points"] == 25


@posix
def test_a_file_without_permission_is_refused(points: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may read everything")
    points.chmod(0)
    done = run("fit", points)
    assert done.returncode == 2
    assert b"permission" in done.stderr


@pytest.mark.parametrize(
    ("content", "words"),
    first_in_default_tier(
        [(b"", b"empty"), (b"\x00\xff", b"binary data"), (b"1 2 3\n4 5\n", b"line 2")]
    ),
)
def test_bad_input_exits_with_2_and_one_line(tmp_path: Path, content: bytes, words: bytes) -> None:
    path = tmp_path / "bad.txt"
    path.write_bytes(content)
    done = run("fit", path, "-o", tmp_path / "out.csv")
    assert done.returncode == 2
    assert done.stdout == b""
    assert words in done.stderr
    assert done.stderr.count(b"\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["bad.txt"]


def test_no_command_imports_qt_or_vtk(points: Path, tmp_path: Path) -> None:
    orientations = tmp_path / "o.csv"
    orientations.write_text("strike,dip\n10,20\n40,30\n80,50\n200,15\n")
    model = tmp_path / "m.obj"
    model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    commands: list[list[Path | str]] = [
        ["fit", points],
        ["stats", orientations],
        ["fold", orientations],
        ["stereonet", orientations, "-o", tmp_path / "net.png"],
        ["info", model, points],
        ["convert", model, tmp_path / "m.glb"],
        ["convert", tmp_path / "m.glb", tmp_path / "m.laz"],
        ["export", tmp_path / "none.vom", "--to", "csv", "-o", tmp_path / "x.csv"],
    ]
    text = repr([[str(word) for word in command] for command in commands])
    script = (
        f"import sys; from vomstudio.cli import main\ncodes = [main(c) for c in {text}]\n"
        "seen = {m.partition('.')[0] for m in sys.modules}\n"
        "bad = seen & {'PySide6', 'shiboken6', 'vtk', 'vtkmodules', 'pyvista', 'qtpy'}\n"
        "sys.stderr.write(f'{codes} {sorted(bad)}')"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        env=environment(MPLBACKEND=""),
        timeout=120,
        check=False,
        text=True,
    )
    assert done.stderr.endswith("[0, 0, 0, 0, 0, 0, 0, 2] []")


def test_small_fit_imports_no_heavy_libraries(points: Path) -> None:
    script = (
        "import sys; from vomstudio.cli import main; main(['fit', sys.argv[1]])\n"
        "heavy = {'pandas', 'scipy.stats', 'matplotlib', 'numba', 'laspy', 'pyproj', 'PIL'}\n"
        "sys.stderr.write(repr(sorted(heavy & set(sys.modules))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(points)],
        capture_output=True,
        env=environment(),
        timeout=60,
        check=False,
        text=True,
    )
    assert done.stderr.endswith("[]")


def processor_seconds(work: Callable[[], object]) -> float:
    """Of the child processes, which other load on the machine does not lengthen much."""
    before = os.times().children_user
    work()
    return os.times().children_user - before


@pytest.mark.full
@posix
def test_small_fit_takes_less_than_half_a_second_of_cpu_time(points: Path) -> None:
    assert min(processor_seconds(lambda: run("fit", points)) for _ in range(3)) < 0.5


@posix
def test_interruption_works_despite_signal_handlers_of_a_library(tmp_path: Path) -> None:
    """COLMAP's logging would print a stack of C++."""
    said = (
        "import os, signal, time\n"
        "from vomstudio.cli.common.stop_signals import interrupt_on_stop_signals\n"
        "from vomstudio.photogrammetry.base.colmap import colmap\n"
        "try:\n"
        "    with interrupt_on_stop_signals():\n"
        "        colmap()\n"
        "        os.kill(os.getpid(), signal.SIGTERM)\n"
        "        time.sleep(20)\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", said],
        capture_output=True,
        env=environment(),
        timeout=60,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGTERM, signal.SIG_DFL),
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"stopped\n", b"")
