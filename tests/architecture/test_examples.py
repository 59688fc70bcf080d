"""The examples in docs/extending.md work, and pass the tests, in a copy of the repository."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "extending.md"
NEW = re.compile(r"^`([\w/]+\.py)`:\n\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
CHANGED = re.compile(
    r"^In `([\w/]+\.\w+)`:\n\n((?:```diff\n.*?^```\n\n?)+)", re.MULTILINE | re.DOTALL
)
HUNK = re.compile(r"^```diff\n(.*?)^```", re.MULTILINE | re.DOTALL)
RUN = re.compile(r"^Then run:\n\n```bash\npython (.*?)\n```", re.MULTILINE)

# Tests that an added file can affect.
AFFECTED = (
    "tests/architecture",
    "tests/project",
    "tests/studio/tools",
    "tests/io/models/test_registry.py",
    "tests/cli/test_contract.py",
    "tests/cli/test_first_words.py",
    "tests/cli/test_help.py",
    "tests/specimens",
    "tests/ui/test_menu_paths.py",
    "tests/ui/test_panels.py",
    "tests/test_words.py",
    "tests/test_messages.py",
    "tests/test_languages.py",
)

USED = """
import json, sys
from pathlib import Path

import numpy as np

from vomstudio.project import edits
from vomstudio.project.kinds import find_kind
from vomstudio.project.kinds.remark import Remark
from vomstudio.geometry.frames import Frame
from vomstudio.project.records import Model
from vomstudio.io.models.opening import read_model
from vomstudio.project.folder import ProjectFolder
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent

here = Path(sys.argv[1])
result = {}

(here / "a.off").write_text("OFF 3 1 0\\n0 0 0\\n2 0 0\\n0 3 0\\n3 0 1 2\\n")
loaded = read_model(here / "a.off")
result["vertices"], result["faces"] = loaded.data.vertices.tolist(), loaded.data.faces.tolist()

project = ProjectFolder.create(here / "p.vom")
session = project.session
session.apply(edits.add_model(session.records, Model(
    "m1", "a", "a.off", "mesh", loaded.content_hash, Frame("crs", "EPSG:32633"))))
entry = next(entry for entry in TOOLS if entry.name == "remark")


class Context:
    next_type_id, next_set = "bedding", ""
    session = session

    def measure(self, feature):
        from vomstudio.project.measurement_cache import measure_all
        return measure_all(session.records, [feature])[0]

    def __getattr__(self, name):
        return lambda *_: None


tool = entry.tool(Context())
hit = Hit("m1", "face", 0, (0.5, 1.0, 0.0), (0.5, 0.25, 0.25))
tool.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit))
(remark,) = session.of(Remark)
session.apply(edits.set_attributes(session.records, [remark.id], notes="slickensides here"))
session.save()
project.close()
again = ProjectFolder.open(here / "p.vom")
(remark,) = again.session.of(Remark)
result["remark"] = [remark.name, remark.notes, list(remark.vertices[0])]
result["kind"] = find_kind("remark").title
again.close()
print(json.dumps(result))
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the repository with all examples of the page in it."""
    folder = tmp_path_factory.mktemp("program")
    for name in git(ROOT, "ls-files", "-z", "-co", "--exclude-standard").split("\0"):
        if name and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    page = PAGE.read_text("utf-8")
    for name, code in NEW.findall(page):
        assert not (folder / name).exists(), f"{name} is there already"
        (folder / name).write_text(code, "utf-8")
    for name, hunks in CHANGED.findall(page):
        text = (folder / name).read_text("utf-8")
        for hunk in HUNK.findall(hunks):
            lines = hunk.splitlines(keepends=True)
            before = "".join(line[line[0] in " -" :] for line in lines if line[0] != "+")
            after = "".join(line[line[0] in " +" :] for line in lines if line[0] != "-")
            assert text.count(before) == 1, f"{name} has other lines than the page shows:\n{hunk}"
            text = text.replace(before, after)
        (folder / name).write_text(text, "utf-8")
    for command in RUN.findall(page):
        in_the_copy(folder, *command.split())
    git(folder, "init", "-q")
    git(folder, "add", "-A")
    return folder


def git(folder: Path, *words: str) -> str:
    try:
        done = subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("git is not installed")
    if done.returncode != 0:
        pytest.skip("this folder is not a git checkout")
    return done.stdout


def in_the_copy(program: Path, *words: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(program)}
    done = subprocess.run(
        [sys.executable, *words], cwd=program, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-4000:]
    return done.stdout


def test_page_has_an_example_of_each_extension_point() -> None:
    page = PAGE.read_text("utf-8")
    folders = {Path(name).parent.as_posix() for name, _ in NEW.findall(page)}
    assert folders == {
        "vomstudio/io/models/formats",
        "vomstudio/project/kinds",
        "vomstudio/studio/tools",
        "vomstudio/ui/panels/tools",
        "vomstudio/cli",
    }
    assert len(CHANGED.findall(page)) == 7
    assert len(RUN.findall(page)) == 3


@pytest.mark.full
def test_example_reader_feature_kind_and_tool_work(program: Path, tmp_path: Path) -> None:
    result = json.loads(in_the_copy(program, "-c", USED, str(tmp_path)))
    assert result["vertices"] == [[0, 0, 0], [2, 0, 0], [0, 3, 0]]
    assert result["faces"] == [[0, 1, 2]]
    assert result["remark"] == ["R01", "slickensides here", [0.5, 1.0, 0.0]]
    assert result["kind"] == "Remark"


@pytest.mark.full
def test_the_command_prints_poles(program: Path, tmp_path: Path) -> None:
    table = tmp_path / "planes.csv"
    table.write_text("dip_direction,dip\n100,30\n")
    result = json.loads(in_the_copy(program, "-m", "vomstudio", "poles", str(table), "--json"))
    # The pole of 100/30 is the line 280/60.
    assert result["n"] == 1
    assert result["poles"][0]["trend_deg"] == pytest.approx(280.0)
    assert result["poles"][0]["plunge_deg"] == pytest.approx(60.0)


@pytest.mark.full
def test_example_panel_and_action_appear_in_window(program: Path) -> None:
    """A window of the copy, with the dock of the tool and the entry of the menu."""
    shown = in_the_copy(
        program,
        "-c",
        "from PySide6.QtWidgets import QApplication\n"
        "application = QApplication([])\n"
        "from vomstudio.io.settings import read_settings\n"
        "from vomstudio.ui.shell.main_window import MainWindow\n"
        "window = MainWindow(read_settings()[0])\n"
        "window._fill()\n"
        "panels = window.tool_panel.panels\n"
        "print('remark' in panels, panels['remark'].count.text())\n"
        "print('select_none' in window.actions_table.all)\n"
        "import os, sys; sys.stdout.flush(); os._exit(0)\n",
    )
    assert shown.split("\n")[:2] == ["True 0 so far", "True"]


@pytest.mark.full
def test_the_linters_and_the_affected_tests_pass(program: Path) -> None:
    in_the_copy(program, "-m", "ruff", "check", ".")
    in_the_copy(program, "-m", "ruff", "format", "--check", ".")
    in_the_copy(program, "-m", "mypy")
    tests = [*AFFECTED, "--deselect=tests/architecture/test_examples.py"]
    in_the_copy(program, "-m", "pytest", "-q", "-n0", "-p", "no:cacheprovider", *tests)
    in_the_copy(program, "-m", "pytest", "-q", "-n0", "-k", "poles", "tests/cli/test_golden.py")
