"""Date and contents of untitled projects that were closed without saving."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.words import tr, tr_n
from vomstudio.project.folder import untitled_projects
from vomstudio.project.journal.database import read_replay
from vomstudio.project.records import Feature, Model

MAX_LISTED = 20


@dataclass(frozen=True)
class DiscardedWork:
    """Untitled project that was closed without saving.

    Parameters
    ----------
    folder : Path
    time : datetime
        Local time at which the project was closed.
    features : int
    models : tuple of str
        Names of the models.
    """

    folder: Path
    time: datetime
    features: int
    models: tuple[str, ...]

    def describe(self) -> str:
        """Return the date, the number of features and the models as text for a menu."""
        time_text = self.time.strftime("%Y-%m-%d %H:%M")
        count = tr_n("{count} feature", "{count} features", self.features)
        if not self.models:
            return tr("{date}: {features}", date=time_text, features=count)
        return tr(
            "{date}: {features} on {models}",
            date=time_text,
            features=count,
            models=", ".join(self.models[:2]) + (" …" if len(self.models) > 2 else ""),
        )


def list_discarded_work() -> list[DiscardedWork]:
    """Return the most recently discarded projects, sorted by time.

    The contents are those before the last edit of the journal, which discarded them and can be
    undone.
    """
    discarded_works = []
    for folder in untitled_projects(finished=True)[:MAX_LISTED]:
        try:
            replay = read_replay(folder)
        except InputError:
            continue
        discarded_work = replay.done[-1][1].before.values() if replay.done else ()
        records = [r for r in (*replay.records.values(), *discarded_work) if r is not None]
        features = {r.id for r in records if isinstance(r, Feature)}
        models = {r.id: r.name for r in records if isinstance(r, Model)}
        time = datetime.fromtimestamp((folder / "journal.sqlite").stat().st_mtime)
        discarded_works.append(DiscardedWork(folder, time, len(features), tuple(models.values())))
    return discarded_works
