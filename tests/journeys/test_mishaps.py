"""What goes wrong around the window: it says so in a sentence, and nothing is lost."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QPushButton

from tests import driver
from tests.driver import key, wait
from tests.journeys.recorded import on_screen
from tests.messages import refused, shown_codes, shown_values
from tests.samples import ZIGZAG
from tests.small_disk import fill, small_disk
from vomstudio.core.files.lock import ProjectLock
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.frames import Frame
from vomstudio.io.models.opening import file_hash, read_model
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import FeatureType, Model
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.commands.project_files import TITLES


def bed_on_model(window, shift: float = 0.0, name: str = "") -> Trace:
    """A trace on the open model, made without the mouse."""
    model = driver.model(window)
    low = window.studio.models[model.id].data.bounds[0] if window.studio.models else (0, 0, 0)
    points = tuple((low[0] + x, low[1] + y, low[2] + z + shift) for x, y, z in ZIGZAG)
    trace = Trace(new_id("trace"), name, "bedding", model.id, model.content_hash, points)
    assert window.studio.attempt(edits.add_trace, trace)
    return window.studio.records[trace.id]


def sentences(window) -> list[str]:
    return [window.messages.item(i).text() for i in range(window.messages.count())]


# --- the worker dies --------------------------------------------------------------------------
@pytest.mark.full
@pytest.mark.usefixtures("new_window")
@pytest.mark.expects_log
def test_killed_worker_is_reported_and_the_next_load_succeeds(window, outcrop, tmp_path):
    jobs = driver.begin_reading(window, tmp_path)
    os.kill(jobs.visible()[0].worker._process.pid, signal.SIGKILL)
    wait(lambda: not jobs.visible(), "the end of the job")
    assert window.message_bar.notice.code == "job.worker-died"
    assert window.message_bar.isVisible()
    assert window.isVisible()
    driver.open_outcrop(window, outcrop)
    assert driver.model(window).frame.crs == driver.CRS


@pytest.mark.full
@pytest.mark.slow
def test_loading_can_be_stopped(window, tmp_path):
    jobs = driver.begin_reading(window, tmp_path)
    wait(window.status_line._stop.isVisible, "the stop button", 5.0)
    window.status_line._stop.click()
    wait(lambda: not jobs.visible(), "the end of the job")
    assert window.studio.models == {}
    wait(window.start_page.isVisible, "the start page", 2.0)


@pytest.mark.full
@pytest.mark.slow
def test_a_closed_window_leaves_no_worker(own_folders, qtbot, outcrop):
    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    processes = [w._process for w in window.studio.jobs.workers.values() if w._process]
    assert processes
    driver.dismiss(window)
    assert all(p.poll() is not None for p in processes)


@pytest.mark.full
def test_window_closed_right_after_creation_leaves_nothing_running(own_folders, qtbot):
    from vomstudio.io.settings import read_settings
    from vomstudio.ui.shell.main_window import MainWindow

    window = MainWindow(read_settings()[0])
    window.show()
    window.begin([])
    window.close()
    driver.pause(300)
    assert all(w._process is None for w in window.studio.jobs.workers.values())
    driver.delete(window)


# --- the disk ---------------------------------------------------------------------------------
@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_work_continues_on_a_full_disk_and_is_written_once_space_is_free(window, outcrop, tmp_path):
    driver.open_outcrop(window, outcrop)
    with small_disk(tmp_path / "disk", 2048) as disk:
        window.studio.save_as(disk / "cliff.vom")
        bed_on_model(window, 0.0, "kept")
        wait(lambda: not window.studio.jobs.jobs, "the layers", 120)
        filler = fill(disk)
        # The log has some room left in its last page.
        for i in range(200):
            assert bed_or_none(window, i) is not None
            if window.studio.project.journal.has_pending_rows:
                break
        assert window.studio.project.journal.has_pending_rows, "the disk was never full"
        notice = window.message_bar.notice
        assert notice.code == "project.steps-in-memory"
        assert notice.message.values["reason_code"] == "disk.full"
        count = len(driver.traces(window))
        key(window, Qt.Key.Key_Z, driver.CTRL)
        assert len(driver.traces(window)) == count - 1
        filler.unlink()
        assert bed_on_model(window, 9.0, "after").name == "after"
        assert window.message_bar.notice.code == "project.on-disk-again"
        after = on_screen(window.studio)
        assert [
            t.name for t in read_replay(disk / "cliff.vom").records.values() if isinstance(t, Trace)
        ] == [t[0] for t in after["traces"]]
        window.studio.session.save()
        window.studio.new_project()


@pytest.mark.full
@pytest.mark.slow
def test_full_disk_does_not_keep_the_window_open(own_folders, qtbot, outcrop, tmp_path):
    from PySide6.QtWidgets import QMessageBox

    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    with small_disk(tmp_path / "disk", 2048) as disk:
        window.studio.save_as(disk / "cliff.vom")
        for i in range(3):
            bed_on_model(window, float(i))
        wait(lambda: not window.studio.jobs.jobs, "the layers")
        fill(disk)
        for i in range(200):
            bed_or_none(window, i)
            if window.studio.project.journal.has_pending_rows:
                break
        seen: list[str] = []
        driver.answer(QMessageBox.StandardButton.Discard, seen)
        closed = window.close()
        assert seen
        assert closed, window.message_bar.text
        driver.delete(window)


def bed_or_none(window, i: int) -> Trace | None:
    model = driver.model(window)
    points = tuple((p[0], p[1], p[2] + i) for p in ZIGZAG)
    trace = Trace(f"t{i}", f"n{i}", "bedding", model.id, model.content_hash, points)
    return trace if window.studio.attempt(edits.add_trace, trace) else None


COAL = FeatureType("coal", "coal", "#202020", "circle")


@contextlib.contextmanager
def held(folder: Path):
    lock = ProjectLock(folder / "lock")
    try:
        yield
    finally:
        lock.release()


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a disk for reading")
def test_read_only_project_can_be_edited_and_saved_elsewhere(window, outcrop, tmp_path):
    with small_disk(tmp_path / "disk", 4096) as disk:
        folder = disk / "cliff.vom"
        driver.open_outcrop(window, outcrop)
        window.studio.save_as(folder)
        window.studio.new_project()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        window.open_path(folder)
        driver.settled(window)
        cache = window.studio.project.cache
        assert any(cache.glob("model-*/meta.json"))
        assert window.studio.project.folder == folder
        notice = window.message_bar.notice
        assert notice.code == "project.steps-in-memory"
        assert notice.message.values["file"] == str(folder)
        assert notice.message.values["reason_code"] == "disk.read-only"
        assert "Save as" in [b.text() for b in window.message_bar.findChildren(QPushButton)][-1]
        title = TITLES["unwritable"].format(project="cliff", unsaved="")
        assert window.windowTitle() == title
        assert not window.studio.has_work_to_save
        assert window.studio.attempt(edits.add_type, COAL)
        title = TITLES["in-memory"].format(project="cliff", unsaved="*")
        assert window.windowTitle() == title
        assert window.studio.has_work_to_save
        assert not window.files.attempt(window.studio.save)
        assert "read-only" in window.message_bar.text
        with pytest.raises(Exception, match="read-only"):
            window.studio.save_as(disk / "other.vom")
        assert window.studio.project.folder == folder
        window.studio.save_as(tmp_path / "elsewhere.vom")
        assert window.windowTitle().startswith("elsewhere – ")
        assert not window.studio.has_work_to_save
        assert COAL.id in read_replay(tmp_path / "elsewhere.vom").records
        assert not cache.exists()
        assert before == {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a disk for reading")
def test_project_on_disk_that_becomes_writable_is_written_and_locked(window, tmp_path):
    with small_disk(tmp_path / "disk", 4096) as disk:
        folder = disk / "cliff.vom"
        window.studio.save_as(folder)
        window.studio.new_project()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        window.open_path(folder)
        assert window.studio.attempt(edits.add_type, COAL)
        assert COAL.id not in read_replay(folder).records
        subprocess.run(["mount", "-o", "remount,rw", str(disk)], check=True)
        other = replace(COAL, id="other", name="other")
        with held(folder):
            # Another program has it now.
            assert window.studio.attempt(edits.add_type, other)
            assert COAL.id not in read_replay(folder).records
        assert window.studio.attempt(edits.add_type, replace(COAL, id="third", name="third"))
        assert window.message_bar.notice.code == "project.on-disk-again"
        assert {COAL.id, "other", "third"} <= set(read_replay(folder).records)
        with refused("project.locked"):
            ProjectFolder.open(folder)
        window.studio.new_project()


@pytest.mark.full
def test_saving_under_a_taken_name_is_rejected_and_keeps_the_project(window, outcrop, tmp_path):
    driver.open_outcrop(window, outcrop)
    (tmp_path / "file.vom").write_text("something")
    (tmp_path / "full.vom").mkdir()
    (tmp_path / "full.vom" / "x").write_text("something")
    before = window.studio.project.folder
    for name, code in (("file.vom", "output.exists"), ("full.vom", "folder.not-empty")):
        assert not window.files.attempt(lambda name=name: window.studio.save_as(tmp_path / name))
        assert window.message_bar.notice.code == code
        assert window.studio.project.folder == before
    assert bed_on_model(window) is not None
    assert [p.name for p in tmp_path.glob("*.part")] == []


# --- two windows ------------------------------------------------------------------------------
@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_a_project_is_open_in_one_window_at_a_time(window, qtbot, outcrop, tmp_path):
    driver.open_outcrop(window, outcrop)
    bed_on_model(window)
    window.studio.save_as(tmp_path / "cliff.vom")
    other = driver.make_window([tmp_path / "cliff.vom"])
    try:
        assert other.studio.project.is_untitled
        assert other.message_bar.notice.code == "project.locked"
        assert str(os.getpid()) in other.message_bar.text
        assert bed_on_model(window, 1.0) is not None
        window.studio.session.save()
        window.studio.new_project()
        other.open_path(tmp_path / "cliff.vom")
        assert len(driver.traces(other)) == 2
    finally:
        driver.dismiss(other)


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
@pytest.mark.slow
def test_work_of_an_open_window_is_not_offered_to_another(window, qtbot, outcrop):
    driver.open_outcrop(window, outcrop)
    bed_on_model(window)
    other = driver.make_window()
    try:
        assert not other.message_bar.isVisible()
    finally:
        driver.dismiss(other)


# --- the model's file -------------------------------------------------------------------------
@pytest.fixture
def project(own_folders, qtbot, outcrop, tmp_path) -> tuple[Path, Path]:
    """A saved project with one bed, closed again; and its model's file."""
    folder = tmp_path / "work" / "cliff.vom"
    made = ProjectFolder.create(folder)
    frame = Frame("crs", driver.CRS)
    model = Model("m1", "outcrop", str(outcrop), "mesh", file_hash(outcrop), frame)
    made.session.apply(edits.add_model(made.session.records, model))
    low = read_model(outcrop).data.bounds[0]
    points = tuple((low[0] + x, low[1] + y, low[2] + z) for x, y, z in ZIGZAG)
    trace = Trace("t1", "the bed", "bedding", "m1", model.content_hash, points)
    made.session.apply(edits.add_trace(made.session.records, trace))
    made.session.save()
    made.close()
    return folder, outcrop


def loaded(window) -> None:
    wait(lambda: not window.studio.loader.busy, "the model")


def reopened(folder: Path):
    window = driver.make_window([folder])
    loaded(window)
    return window


def shows_the_bed(window) -> None:
    assert [t.name for t in driver.traces(window)] == ["the bed"]
    (trace,) = driver.traces(window)
    assert window.studio.measured([trace.id])[trace.id].fit is not None
    assert window.table.model.rowCount() == 1


@pytest.mark.full
def test_missing_model_is_reported_keeps_features_and_can_be_located(project, tmp_path):
    folder, file = project
    moved = tmp_path / "elsewhere"
    shutil.move(str(file.parent), str(moved))
    window = reopened(folder)
    assert "outcrop" in window.message_bar.text
    assert "Locate" in window.message_bar.text
    assert [b.text() for b in window.message_bar.findChildren(QPushButton)] == ["Locate file…"]
    shows_the_bed(window)
    (trace,) = driver.traces(window)
    points = window.studio.measured([trace.id])[trace.id].points
    assert window.viewport.project(points)[1].all(), "the features are in sight without the model"
    assert window.actions_table.all["locate"].isEnabled()
    driver.keep_picture(window, "mishap-missing-model")
    # Not this file.
    wrong = moved / "outcrop2.obj"
    wrong.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    model_id = driver.model(window).id
    window.studio.locate_model(model_id, wrong)
    loaded(window)
    assert window.message_bar.notice.code == "model.other-file"
    assert window.studio.models == {}
    window.studio.locate_model(model_id, moved / "outcrop.obj")
    driver.settled(window)
    assert not window.actions_table.all["locate"].isEnabled()
    window.studio.save()
    driver.dismiss(window)
    window = reopened(folder)
    driver.settled(window)
    shows_the_bed(window)
    driver.dismiss(window)


@pytest.mark.full
@pytest.mark.slow
def test_a_model_moved_together_with_its_project_is_found(project, tmp_path):
    folder, file = project
    target = tmp_path / "usb"
    target.mkdir()
    shutil.move(str(folder), str(target / "cliff.vom"))
    for each in file.parent.iterdir():
        shutil.move(str(each), str(target))
    shutil.rmtree(file.parent)
    window = reopened(target / "cliff.vom")
    driver.settled(window)
    shows_the_bed(window)
    driver.dismiss(window)


@pytest.mark.full
def test_changed_model_is_reported_and_no_feature_moves(project):
    folder, file = project
    time.sleep(0.01)
    lines = file.read_text().splitlines()
    lines = [
        f"v {float(w[1]) + 1:.4f} {w[2]} {w[3]}" if (w := line.split()) and w[0] == "v" else line
        for line in lines
    ]
    file.write_text("\n".join(lines) + "\n")
    window = reopened(folder)
    assert "has changed" in window.message_bar.text
    assert window.studio.models == {}
    shows_the_bed(window)
    assert not window.studio.session.dirty
    driver.dismiss(window)


@pytest.mark.full
@pytest.mark.slow
def test_damaged_model_is_reported_and_features_remain(project):
    folder, file = project
    file.write_bytes(b"\0\1\2" * 1000)
    window = reopened(folder)
    assert "outcrop" in window.message_bar.text
    shows_the_bed(window)
    driver.dismiss(window)


# --- damaged things ---------------------------------------------------------------------------
@pytest.mark.full
def test_window_works_despite_a_damaged_first_row(project):
    """The row that holds the feature types: everything else is still there."""
    import sqlite3

    folder, _ = project
    db = sqlite3.connect(folder / "journal.sqlite")
    db.execute("UPDATE journal SET after = '{not json' WHERE seq = 1")
    db.commit()
    db.close()
    window = reopened(folder)
    assert any("project.parts-left-out" in shown_codes(s) for s in sentences(window))
    shows_the_bed(window)
    assert len(window.net.contents().sets) == 1
    driver.settled(window)
    assert bed_on_model(window, 1.0).name == "B01"
    driver.keep_picture(window, "mishap-damaged-row")
    driver.dismiss(window)


@pytest.mark.full
def test_message_bar_shows_skipped_rows_last(project):
    """Not that unsaved work was restored, nor one damaged row as if it were the only one."""
    import sqlite3

    folder, _ = project
    opened = ProjectFolder.open(folder)
    (bed,) = opened.session.of(Trace)
    for i in range(3):
        more = replace(bed, id=f"t{2 + i}", name=f"bed {2 + i}")
        opened.session.apply(edits.add_trace(opened.session.records, more))
    opened.close()
    db = sqlite3.connect(folder / "journal.sqlite")
    (last,) = db.execute("SELECT max(seq) FROM journal").fetchone()
    db.execute("UPDATE journal SET after = '{not json' WHERE seq > ?", (last - 2,))
    db.commit()
    db.close()
    window = reopened(folder)
    said = sentences(window)
    assert any("project.recovered" in shown_codes(s) for s in said)
    left_out = [s for s in said if "project.parts-left-out" in shown_codes(s)]
    counts = [shown_values(s, "project.parts-left-out")["count"] for s in left_out]
    assert counts == ["1", "1", "2"]
    notice = window.message_bar.notice
    assert (notice.code, notice.message.values["count"]) == ("project.parts-left-out", 2)
    assert f"row {last - 1} " in window.message_bar.text
    driver.settled(window)
    driver.keep_picture(window, "mishap-damaged-rows")
    driver.dismiss(window)


@pytest.mark.full
@pytest.mark.parametrize(
    "content", [b"", b"not a database at all", b"SQLite format 3\0" + b"\0" * 84]
)
def test_invalid_project_is_rejected_and_the_open_one_stays(window, tmp_path, content):
    folder = tmp_path / "bad.vom"
    folder.mkdir()
    (folder / "journal.sqlite").write_bytes(content)
    before = window.studio.project.folder
    window.open_path(folder)
    assert window.studio.project.folder == before
    assert "bad.vom" in window.message_bar.text
    window.open_path(tmp_path / "nowhere.vom")
    assert "file.missing" in shown_codes(window.message_bar.text)


@pytest.mark.full
def test_unreadable_settings_are_reported_and_defaults_are_used(own_folders, qtbot):
    (own_folders / "settings.toml").write_text("notation = [not toml")
    window = driver.make_window()
    assert "settings.unreadable" in shown_codes(window.message_bar.text)
    assert window.studio.settings.notation == "dipdir/dip"
    driver.dismiss(window)


def test_restore_button_brings_back_recovered_work(own_folders, qtbot):
    import sys

    from PySide6.QtWidgets import QPushButton

    done = subprocess.Popen(
        [sys.executable, "-m", "tests.journeys.recorded", "studio", "--step"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).resolve().parents[2],
    )
    with done:
        done.stdout.readline()
        for _ in range(11):
            done.stdin.write("\n")
            done.stdin.flush()
            done.stdout.readline()
        done.kill()
    window = driver.make_window()
    wait(window.message_bar.isVisible, "the offer", 5.0)
    assert window.message_bar.notice.code == "project.unsaved-found"
    driver.keep_picture(window, "mishap-recovery")
    (button,) = [b for b in window.message_bar.findChildren(QPushButton) if b.text() == "Restore"]
    button.click()
    assert [t.name for t in driver.traces(window)] == ["B01"]
    assert len(window.studio.get_tool(TraceTool).vertices) == 2
    assert window.studio.tool_name == "trace"
    driver.keep_picture(window, "mishap-recovered")
    driver.dismiss(window)


@pytest.mark.full
def test_message_about_opened_path_precedes_the_restore_offer(own_folders, tmp_path):
    for name in ("left.vom", "asked.vom"):
        ProjectFolder.create(tmp_path / name).close()
    (own_folders / "settings.toml").write_text(
        f"unclosed = ['{tmp_path / 'left.vom'}', '{tmp_path / 'asked.vom'}']\n"
    )
    (tmp_path / "bad.vom").mkdir()
    window = driver.make_window([tmp_path / "bad.vom"])
    assert "bad.vom" in window.message_bar.text
    (offer,) = [s for s in sentences(window) if "project.unclosed" in shown_codes(s)]
    assert shown_values(offer, "project.older-unclosed") == {"count": "1"}
    driver.dismiss(window)
    # What is opened anyway is not offered.
    window = driver.make_window([tmp_path / "asked.vom"])
    assert shown_codes(window.message_bar.text) == {"project.unclosed"}
    assert window.message_bar.text.startswith("left ")
    driver.dismiss(window)


@pytest.mark.full
@pytest.mark.slow
def test_layers_match_saved_state_if_the_window_closes_after_an_edit(
    own_folders, qtbot, outcrop, tmp_path
):
    import sqlite3

    from PySide6.QtWidgets import QMessageBox

    folder = tmp_path / "cliff.vom"

    def beds() -> int:
        db = sqlite3.connect(folder / "project.gpkg")
        (count,) = db.execute("SELECT count(*) FROM planes").fetchone()
        db.close()
        return count

    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    bed_on_model(window)
    window.studio.save_as(folder)
    bed_on_model(window, 1.0)
    window.files.save()
    driver.close(window)
    assert beds() == 2
    assert [p.name for p in folder.iterdir() if "gpkg" in p.name] == ["project.gpkg"]
    window = driver.make_window([folder])
    driver.settled(window)
    bed_on_model(window, 2.0)
    wait(lambda: beds() == 3, "the layers of an idle window")
    driver.answer(QMessageBox.StandardButton.Discard, [])
    driver.close(window)
    assert beds() == 2
    window = driver.make_window([folder])
    window.actions_table.run("select_all")
    window.actions_table.run("delete")
    window.files.save()
    assert not (folder / "project.gpkg").exists()
    driver.dismiss(window)


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_failure_to_create_a_project_is_reported_and_the_open_one_stays(
    window, monkeypatch, tmp_path
):
    (tmp_path / "taken").write_text("a file")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "taken"))
    # Nor is there room among the temporary files.
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "taken"))
    before = window.studio.project
    window.actions_table.run("new")
    assert window.studio.project is before
    assert window.message_bar.notice.code == "folder.not-created"


@pytest.mark.full
def test_panels_keep_position_and_size_after_restart(own_folders, qtbot):
    def places(window) -> dict[str, tuple[int, ...]]:
        driver.pause(50)
        found = {
            name: (dock.x(), dock.y(), dock.width(), dock.height())
            for name, dock in window.docks.items()
            if dock.isVisible() and not dock.visibleRegion().isEmpty()
        }
        found["viewport"] = (window.viewport.width(), window.viewport.height())
        return found

    window = driver.make_window()
    first = places(window)
    driver.dismiss(window)
    window = driver.make_window()
    assert places(window) == first
    window.resizeDocks([window.docks["project"]], [340], Qt.Orientation.Horizontal)
    window.docks["properties"].hide()
    changed = places(window)
    assert changed != first
    window.actions_table.run("only_outcrop")
    driver.dismiss(window)
    for _ in range(2):
        window = driver.make_window()
        assert places(window) == changed
        driver.dismiss(window)


@pytest.mark.full
def test_changing_the_frame_unit_keeps_the_model_in_view(window, outcrop):
    driver.open_outcrop(window, outcrop)
    model_id = driver.model(window).id
    window.studio.attempt(edits.declare_frame, model_id, Frame("local", None, 0.001, "y"))
    driver.pause(400)
    centre = window.studio.models[model_id].data.bounds.mean(axis=0)
    x, y, z = centre * 0.001
    pixels, _ = window.viewport.project([(x, -z, y)])
    assert 0 < pixels[0, 0] < window.viewport.width()
    assert 0 < pixels[0, 1] < window.viewport.height()
