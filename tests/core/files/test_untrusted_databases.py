"""SQLite files of strangers: which schema is read, by which connection, in which process."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests.fuzz import bent_schemas, campaigns
from tests.tiers import first_in_default_tier
from vomstudio.cli import main
from vomstudio.core.errors import InputError
from vomstudio.core.failures import stop_requests
from vomstudio.core.files.untrusted.databases import (
    open_read_only,
    require_geopackage,
    restrict_connection,
)
from vomstudio.io.gis import vector_layers
from vomstudio.io.gis.line_reading import read_gis_lines

PROGRAM = Path(__file__).parents[3] / "vomstudio"
posix = pytest.mark.skipif(os.name != "posix", reason="no process signals itself there")


def bent(folder: Path, how: str, seed: int = 0) -> Path:
    number = next(i for i, (bend, _) in enumerate(bent_schemas.BENDS) if bend.__name__ == how)
    return bent_schemas.make(folder, number, seed)[0]


UNSAFE = [b.__name__ for b, expected in bent_schemas.BENDS if expected in ("refused", "closed")]
HONEST = [b.__name__ for b, expected in bent_schemas.BENDS if expected == "read"]


@pytest.mark.parametrize("how", UNSAFE)
@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4])
def test_unsafe_schema_is_refused_without_running_it(how: str, seed: int, tmp_path: Path) -> None:
    path = bent(tmp_path, how, seed)
    begun = time.monotonic()
    with pytest.raises((InputError, ValueError)) as error:
        require_geopackage(path)
    assert time.monotonic() - begun < 2.0
    if not isinstance(error.value, InputError):
        # SQLite itself does not accept such a schema.
        assert how in ("_hidden_in_the_schema", "_foreign_module")
        return
    assert (error.value.code, error.value.file) == ("file.unsafe-schema", str(path))
    assert str(error.value.values["name"]).encode() in path.read_bytes()


@pytest.mark.parametrize("how", HONEST)
def test_files_of_common_programs_are_read(how: str, tmp_path: Path) -> None:
    path = bent(tmp_path, how)
    require_geopackage(path)
    assert len(read_gis_lines(path).lines) == 40


def test_refusal_is_passed_on_from_reader_process(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = bent(tmp_path, "_endless_system_table")
    with pytest.raises(InputError) as error:
        read_gis_lines(path)
    assert (error.value.code, error.value.file) == ("file.unsafe-schema", str(path))
    assert main(["fractures", str(path), "--json"]) == 2
    assert '"file.unsafe-schema"' in capsys.readouterr().out


def test_every_geopackage_is_read_in_a_process_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However small, and whatever it is called."""
    path = bent(tmp_path, "_nothing").rename(tmp_path / "lines.geojson")
    assert path.stat().st_size < 200_000

    def read_here(*_: object) -> None:
        raise AssertionError("read in this process")

    monkeypatch.setattr(vector_layers, "read_named_layers", read_here)
    assert len(read_gis_lines(path).lines) == 40


def test_stop_request_interrupts_endless_statement(tmp_path: Path) -> None:
    path = tmp_path / "a.sqlite"
    sqlite3.connect(path).close()
    timer = threading.Timer(0.3, stop_requests._received_signals.append, args=(signal.SIGTERM,))
    try:
        with closing(open_read_only(path)) as db:
            timer.start()
            with pytest.raises(sqlite3.OperationalError, match="interrupt"):
                db.execute(f"{bent_schemas.ENDLESS} SELECT count(*) FROM n").fetchone()
    finally:
        timer.join()
        stop_requests.clear_state()


def test_functions_with_side_effects_do_not_run_from_a_schema() -> None:
    with closing(sqlite3.connect(":memory:")) as db:
        db.create_function("acts", 0, lambda: 1)
        db.execute("CREATE VIEW v AS SELECT acts()")
        assert db.execute("SELECT * FROM v").fetchone() == (1,)
        restrict_connection(db)
        with pytest.raises(sqlite3.OperationalError, match="unsafe"):
            db.execute("SELECT * FROM v")


def test_sqlite_connections_to_foreign_files_are_restricted() -> None:
    """Connections to files of others are limited; these modules have made or checked theirs."""
    own = {
        "project/exports/geopackage.py",  # writes into what it has just made
        "project/journal/file_watch.py",  # copies of a journal that is open
        "photogrammetry/align/match_database.py",  # COLMAP's, in a process of its own
    }
    found = set()
    for module in PROGRAM.rglob("*.py"):
        text = module.read_text("utf-8")
        if "sqlite3.connect(" in text and "restrict_connection(" not in text:
            found.add(module.relative_to(PROGRAM).as_posix())
        # What is opened only to be read goes through `open_to_read`.
        assert "mode=ro" not in text or module.name == "databases.py", module
    assert found == own


# --- signals --------------------------------------------------------------------------------------
BUSY_READER = """
import sys

class Busy:
    def find_spec(self, name, path=None, target=None):
        if name == "pyogrio":
            from collections import deque
            from itertools import repeat
            deque(repeat(0), maxlen=0)

if "vomstudio.io.gis.vector_layers" in sys.orig_argv:
    sys.meta_path.insert(0, Busy())
"""


@posix
@pytest.mark.parametrize(
    "name", first_in_default_tier(["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"], 1)
)
def test_signal_ends_reader_and_its_process(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """GDAL is busy with a file that its schema does not give away: a reader that never answers."""
    (tmp_path / "sitecustomize.py").write_text(BUSY_READER)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    path = bent(tmp_path, "_nothing")
    code, ended_s, left = campaigns.end_by_signal(
        ["fractures", str(path)], getattr(signal, name), 3.0
    )
    assert (code, left) == (-signal.SIGKILL if name == "SIGKILL" else 130, 0)
    assert 0.0 < ended_s < campaigns.MAX_END_S


NATIVE = """
import sys
import vomstudio.app, vomstudio.cli
from collections import deque
from hashlib import pbkdf2_hmac
from itertools import repeat

def busy(words):
    print("busy", flush=True)
    {native}

vomstudio.cli.main = busy
sys.argv = ["vomstudio", "info", "a.obj"]
raise SystemExit(vomstudio.app.main())
"""
HOLDING = "deque(repeat(0), maxlen=0)"
RELEASING = "pbkdf2_hmac('sha256', b'a', b'b', 2**31 - 1)"


def busy(native: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", NATIVE.format(native=native)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=campaigns.default_signals,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "busy\n"
    return process


@pytest.mark.full
@posix
@pytest.mark.parametrize("native", [HOLDING, RELEASING], ids=["holding", "releasing"])
def test_a_second_ctrl_c_ends_the_program_inside_native_code(native: str) -> None:
    process = busy(native)
    try:
        for _ in range(2):
            time.sleep(0.2)
            process.send_signal(signal.SIGINT)
        assert process.wait(3.0) == -signal.SIGINT
    finally:
        process.kill()
        process.communicate()


@pytest.mark.full
@posix
@pytest.mark.parametrize("name", first_in_default_tier(["SIGINT", "SIGTERM", "SIGHUP"], 1))
def test_one_signal_ends_native_code_that_releases_the_gil(name: str) -> None:
    process = busy(RELEASING)
    try:
        time.sleep(0.2)
        begun = time.monotonic()
        process.send_signal(getattr(signal, name))
        out, err = process.communicate(timeout=5.0)
        assert time.monotonic() - begun < campaigns.MAX_END_S
    finally:
        process.kill()
    assert (process.returncode, out, err) == (130, "", "vomstudio: Cancelled.\n")


# --- campaigns ------------------------------------------------------------------------------------
@pytest.mark.full
def test_modified_schemas_are_refused_or_read() -> None:
    counts, wrong = bent_schemas.campaign(3 * len(bent_schemas.BENDS), seed=7)
    assert wrong == []
    assert counts["file.unsafe-schema"] >= 18
    assert counts["read"] >= 9
