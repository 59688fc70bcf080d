"""Verification that every row of a project is intact and every referenced file exists."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.project.assets import asset_path, is_intact
from vomstudio.project.edit import Edit
from vomstudio.project.journal.database import read_schema_and_replay
from vomstudio.project.journal.replay import Replay
from vomstudio.project.records import Asset, Feature, Mask, Model, Record


@dataclass(frozen=True)
class Verification:
    """Result of a verification.

    `schema` is the schema version of the journal, `steps` is the number of steps that can be
    undone, and `sound` is True if the project has no problems, as in the output of the command.
    """

    schema: int
    steps: int
    models: int
    features: int
    assets: int
    problems: tuple[Finding, ...]

    @property
    def sound(self) -> bool:
        return not self.problems


def verify(folder: Path) -> Verification:
    """Verify a project without changing it; it may be open in a window.

    Raises InputError if the folder is not a project or was written by a newer version.
    """
    schema, replay_result = read_schema_and_replay(folder)
    records = replay_result.records.values()
    assets_by_name = named_assets(replay_result)
    problems = [*replay_result.problems]
    for asset in assets_by_name:
        try:
            path = asset_path(folder, asset)
            if not is_intact(path):
                problems.append(Finding("asset.damaged", path=path))
        except InputError as error:
            problems.append(to_finding(error))
        except OSError as error:
            problems.append(Finding("asset.unreadable", path=asset.path, reason=error))
    return Verification(
        schema,
        len(replay_result.done),
        sum(isinstance(record, Model) for record in records),
        sum(isinstance(record, Feature) for record in records),
        len(assets_by_name),
        tuple(problems),
    )


def named_assets(replay_result: Replay) -> list[Asset]:
    """Return all files that undo, redo or discard may need."""
    steps = [edit for _, edit in (*replay_result.done, *replay_result.undone)]
    return collect_assets(
        replay_result.records.values(), replay_result.saved_records.values(), steps
    )


def collect_assets(
    now: Iterable[Record], saved_records: Iterable[Record], steps: Iterable[Edit]
) -> list[Asset]:
    """Return the files referenced by records that exist, were saved, or belong to a step."""
    assets: dict[str, Asset] = {}
    changed_records = (
        record for edit in steps for record in (*edit.before.values(), *edit.after.values())
    )
    for record in (*now, *saved_records, *changed_records):
        if isinstance(record, Mask):
            assets[record.file.path] = record.file
    return list(assets.values())
