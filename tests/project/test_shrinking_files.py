"""Files that become shorter while they are open: a sentence, and no signal of the system.

In processes of their own, because the system ends one that touches a map of which the file has
become shorter.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.tiers import first_in_default_tier

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="no file can be cut there while it is open"
)

_JOURNAL = """
import json, os, sys
from pathlib import Path
from tests.project.test_vanishing_ground import MODEL
from tests.samples import bed
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay

folder, name, size, over = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), sys.argv[4] == "over"
project = ProjectFolder.create(folder)
project.session.apply(edits.add_model(project.session.records, MODEL))
for k in range(40):
    project.session.apply(edits.add_trace(project.session.records, bed(f"t{k}")))
project.session.save()
told = []
if over:
    project.buffer_unwritten_steps(told.append)
os.truncate(folder / name, min(size, (folder / name).stat().st_size))
said = []
for k in range(3):
    try:
        project.session.apply(edits.add_trace(project.session.records, bed(f"u{k}")))
        project.session.save()
    except Exception as error:
        said.append([type(error).__name__, str(error)])
elsewhere = folder.with_name("elsewhere.vom")
kept = len(project.session.records)
try:
    project.save_as(elsewhere)
except Exception as error:
    said.append([type(error).__name__, str(error)])
project.close()
found = len(read_replay(elsewhere).records) if elsewhere.is_dir() else None
print(json.dumps({"said": said, "kept": kept, "found": found, "told": [str(t) for t in told]}))
"""

_PICTURE = """
import os, sys
from vomstudio.core.files.untrusted.pictures import open_picture
path = sys.argv[1]
with open_picture(path) as picture:
    os.truncate(path, 4096)
    try:
        picture.load()
        picture.tobytes()
        print("read")
    except (OSError, ValueError, SyntaxError) as error:
        print("refused")
with open("/proc/self/maps") as maps:
    print(any(path in line for line in maps))
"""

_CACHE = """
import os, sys
from pathlib import Path
import numpy as np
from vomstudio.io.models import model_cache
from vomstudio.io.models.opening import read_model

path, folder = Path(sys.argv[1]), Path(sys.argv[2])
if sys.argv[3] == "again":
    model_cache.load(path, folder)
loaded = model_cache.load(path, folder)
for file in folder.iterdir():
    os.truncate(file, 100)
os.truncate(path, 100)
print(float(np.nansum(loaded.data.vertices)), loaded.data.faces.sum())
"""


def ran(program: str, *words: object) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program, *map(str, words)],
        cwd=Path(__file__).resolve().parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, (done.returncode, done.stderr[-2000:])
    return done.stdout


@pytest.mark.parametrize("over", first_in_default_tier(["over", "at once"], 2))
@pytest.mark.parametrize("size", first_in_default_tier([0, 1000, 4096, 20_000]))
@pytest.mark.parametrize(
    "name", first_in_default_tier(["journal.sqlite", "journal.sqlite-wal", "journal.sqlite-shm"], 2)
)
def test_shrinking_journal_file_is_reported_without_a_crash(
    tmp_path: Path, name: str, size: int, over: str
) -> None:
    answer: dict[str, Any] = json.loads(ran(_JOURNAL, tmp_path / "a.vom", name, size, over))
    if name.endswith("-shm"):
        # It is made again from the log.
        assert (answer["said"], answer["told"]) == ([], [])
    assert all(kind == "NotWritten" for kind, _ in answer["said"])
    assert all(str(tmp_path / "a.vom") in words for _, words in answer["said"])
    # Everything that was shown as done is elsewhere, with what was done since.
    assert answer["found"] == answer["kept"]
    assert answer["kept"] >= (44 if over == "over" or name.endswith("-shm") else 41)


@pytest.mark.parametrize(
    "name",
    first_in_default_tier(["grey.bmp", "grey.tif", "small.tif", "a.png", "a.jpg", "a.tga"], 2),
)
def test_shrinking_image_file_does_not_crash(tmp_path: Path, name: str) -> None:
    pixels = np.random.default_rng(1).integers(0, 255, (700, 900)).astype(np.uint8)
    options = {"compression": "tiff_deflate"} if name == "small.tif" else {}
    Image.fromarray(pixels).save(tmp_path / name, **options)
    said, mapped = ran(_PICTURE, tmp_path / name).split()
    assert mapped == "False"
    assert said in ("read", "refused")


@pytest.mark.parametrize("when", ["first", "again"])
def test_shrinking_model_file_and_cache_do_not_change_loaded_data(
    tmp_path: Path, when: str
) -> None:
    n = 60
    x, y = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    lines = [f"v {a} {b} 1" for a, b in zip(x, y, strict=True)]
    corners = [i for i in range(1, n * (n - 1) + 1) if i % n]
    lines += [f"f {i} {i + 1} {i + n}" for i in corners]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    total, faces = ran(_CACHE, tmp_path / "a.obj", tmp_path / "cache" / "m", when).split()
    assert float(total) == float(x.sum() + y.sum() + n * n)
    assert int(faces) == sum(3 * i + 1 + n - 3 for i in corners)
