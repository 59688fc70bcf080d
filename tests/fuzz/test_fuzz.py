"""Short runs of the campaigns, and every file that once fell."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.fuzz import bent_pictures, hostile, no_files, projects, readers, swollen
from tests.tiers import first_in_default_tier

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="the readers' limits are Linux's"
)


@pytest.mark.full
def test_corrupted_files_are_read_or_refused_by_name() -> None:
    counts, wrong, _ = readers.campaign(250, seed=7)
    assert wrong == []
    assert counts["read"] > 20  # the sound ones are sound
    assert counts["refused"] > 20


def test_files_that_reach_new_lines_are_mutated_further() -> None:
    counts, wrong, pool = readers.campaign(60, seed=7, only="control", guided=True)
    assert wrong == []
    assert sum(counts.values()) >= 61
    assert any("control" in file for file, _ in pool.lines)
    assert pool.kept > 1


def test_flipped_bits_change_no_result_silently() -> None:
    counts, wrong = projects.campaign(projects.flip_bit, 12, 7, same=True)
    assert wrong == []
    assert sum(counts.values()) == 12


@pytest.mark.full
def test_invalid_rows_are_reported_or_refused() -> None:
    counts, wrong = projects.campaign(projects.odd_row, 8, 7, same=False)
    assert wrong == []
    assert counts["named"] + counts["sound"] + counts["refused"] == 8


def test_record_with_numeric_name_is_reported_and_skipped(tmp_path_factory) -> None:  # type: ignore[no-untyped-def]
    import json
    import sqlite3

    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.journal.rows import COLUMNS, checksum
    from vomstudio.project.paths import JOURNAL_NAME

    project = projects.specimen(tmp_path_factory.mktemp("a"))
    db = sqlite3.connect(project / JOURNAL_NAME)
    rows = [list(r) for r in db.execute(f"SELECT {COLUMNS} FROM journal ORDER BY seq")]
    row = next(r for r in reversed(rows) if r[5] and '"record":"trace"' in r[5])
    after = json.loads(row[5])
    id_ = next(i for i, plain in after.items() if plain and plain.get("record") == "trace")
    after[id_]["name"] = 7
    row[5] = json.dumps(after)
    total = ""
    for values in rows:
        total = checksum(total, values)
        db.execute(
            "UPDATE journal SET after = ?, checksum = ? WHERE seq = ?",
            (values[5], total, values[0]),
        )
    db.execute("UPDATE head SET checksum = ?", (total,))
    db.commit()
    db.close()
    opened = ProjectFolder.open(project)
    assert id_ not in opened.session.records
    messages = [str(problem) for problem in opened.problems]
    assert any(f"row {row[0]} " in message and "name" in message for message in messages)
    opened.close()


@pytest.mark.full
def test_hostile_folders_do_not_block_reading() -> None:
    counts, wrong = hostile.campaign(120, seed=7)
    assert wrong == []
    assert counts["read"] > 60


@pytest.mark.parametrize(
    "kind", first_in_default_tier(["t.csv", "b.las", "w.tif", "l.shp", "run/"])
)
def test_irregular_files_are_refused_by_name(kind: str) -> None:
    counts, wrong = no_files.campaign(kind)
    assert wrong == []
    assert counts["refused"] >= len(no_files.ODD)


@pytest.mark.full
def test_falsified_archives_are_read_or_refused_by_name() -> None:
    counts, wrong = hostile.campaign(60, seed=7, only="cloud.npz")
    assert wrong == []
    assert counts["read"] > 0


@pytest.mark.parametrize("kind", first_in_default_tier(["t.csv", "s.stl", "k.kml"], 1))
def test_inflated_files_use_limited_memory(kind: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    # Less than is promised, for files that are smaller than those of a long run.
    said = swollen.campaign(40, tmp_path, only=kind, way="more", free_bytes=200 << 20)
    assert len(said) == 1
    assert not said[0].startswith("WRONG"), said[0]


@pytest.mark.parametrize(
    ("kind", "free"), first_in_default_tier([("a.glb", 100), ("a.ply", 200), ("b.xyz", 100)], 1)
)
@pytest.mark.full
def test_valid_models_need_little_more_than_twice_their_size(
    kind: str, free: int, tmp_path: Path
) -> None:
    said = swollen.campaign(60, tmp_path, only=kind, way="sound", free_bytes=free << 20)
    assert said
    assert all(line.endswith("  read") and not line.startswith("WRONG") for line in said), said


def test_sample_of_corrupted_images_is_read_within_budget() -> None:
    counts, wrong = bent_pictures.campaign(9, seed=7)
    assert wrong == []
    assert counts["file.picture-too-large"] > 0


@pytest.mark.full
def test_corrupted_images_are_read_within_budget() -> None:
    counts, wrong = bent_pictures.campaign(90, seed=11)
    assert wrong == []
    assert counts["file.picture-too-large"] > 50
    assert counts["read"] > 50
