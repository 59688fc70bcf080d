"""Every command and every block of Python of the documents runs in a fresh copy of the repository.

The copy contains the tracked files and nothing else. The blocks of a page run in their order and in
the root of the copy, so that a later one may use what an earlier one wrote.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    "README.md",
    "docs/first_steps.md",
    "docs/worked_example.md",
    "docs/cli.md",
    "docs/api.md",
)
# `packaging/test` is the run that this test belongs to.
NOT_RUN = {"packaging/test"}
CONTINUED = re.compile(r"\\\n *")
PRINTED = re.compile(r"^print\(.*\)  # (.+)$", re.MULTILINE)
TIMEOUT_S = 3600


@dataclass(frozen=True)
class Block:
    """A block of code of a page.

    Attributes
    ----------
    language : str
        "sh" for commands of a terminal (also of an indented block), else that of the fence.
    line : int
        Number of its first line of code, from 1.
    code : str
        Its lines, without the indentation of an indented block.
    """

    language: str
    line: int
    code: str


def blocks_of(text: str) -> list[Block]:
    """Find the fenced and the indented blocks of a page of Markdown, in their order.

    Indented lines below an item of a list belong to the item.
    """
    blocks: list[Block] = []
    lines = text.splitlines()
    number, in_list = 0, False
    while number < len(lines):
        line = lines[number]
        if line.startswith("```"):
            end = lines.index("```", number + 1)
            language = line.strip("`").strip() or "sh"
            blocks.append(Block(language, number + 2, "\n".join(lines[number + 1 : end])))
            number = end + 1
            continue
        if line.startswith("    ") and not in_list:
            end = number
            while end < len(lines) and lines[end].startswith("    "):
                end += 1
            code = "\n".join(line[4:] for line in lines[number:end])
            blocks.append(Block("sh", number + 1, code))
            number = end
            continue
        if line.strip():
            in_list = bool(re.match(r"([-*]|\d+\.) ", line)) or (in_list and line.startswith(" "))
        number += 1
    return blocks


@dataclass(frozen=True)
class Checkout:
    """A fresh copy of the repository with an installation in its `.venv`.

    Attributes
    ----------
    folder : Path
        Root of the copy.
    environment : dict of str
        Variables of the processes that run in it; it has no display.
    """

    folder: Path
    environment: dict[str, str]

    def run(self, *words: str, place: str) -> str:
        """Run a program in the copy and return its standard output. It must succeed."""
        done = subprocess.run(
            words,
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
        )
        assert done.returncode == 0, f"{place} ended with {done.returncode}:\n{done.stderr[-3000:]}"
        return done.stdout


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    folder = tmp_path / "vomstudio"
    for name in tracked_files():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    return Checkout(folder, install(folder, tmp_path / "home"))


def tracked_files() -> list[str]:
    """Names of the files of the repository, relative to its root; skips without git."""
    try:
        done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("git is not installed")
    if done.returncode != 0:
        pytest.skip("this folder is not a git checkout")
    return [name for name in done.stdout.split("\0") if name]


def install(folder: Path, home: Path) -> dict[str, str]:
    """Make the `.venv` of a copy from the Python that runs the tests, and return its variables."""
    scripts = folder / ".venv" / "bin"
    scripts.mkdir(parents=True)
    start = {"python": "", "vomstudio": " -P -m vomstudio"}
    for name, options in start.items():
        (scripts / name).write_text(f'#!/bin/sh\nexec "{sys.executable}"{options} "$@"\n')
        (scripts / name).chmod(0o755)
    home.mkdir()
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "VOMSTUDIO_SETTINGS")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    environment |= {
        "PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(folder),
        "HOME": str(home),
        "XDG_STATE_HOME": str(home / "state"),
        "XDG_CONFIG_HOME": str(home / "config"),
    }
    stamp = 'source packaging/_setup.sh; wanted_stamp run | tee "$stamp" >"$stamp-run"'
    subprocess.run(["bash", "-c", stamp], cwd=folder, env=environment, check=True)
    return environment


@pytest.mark.full
@pytest.mark.skipif(sys.platform == "win32", reason="the documents show commands of a shell")
@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs_from_a_fresh_checkout(page: str, checkout: Checkout) -> None:
    text = (checkout.folder / page).read_text("utf-8")
    blocks = blocks_of(text)
    assert blocks
    assert {block.language for block in blocks} <= {"sh", "python"}
    position = 0
    while position < len(blocks):
        block = blocks[position]
        if block.language == "sh":
            for command in CONTINUED.sub(" ", block.code).splitlines():
                if command not in NOT_RUN:
                    checkout.run("bash", "-c", command, place=f"{page}: {command}")
            position += 1
            continue
        # What follows without a command between shares its names, as in a notebook.
        end = position
        while end < len(blocks) and blocks[end].language == "python":
            end += 1
        run_python(checkout, page, blocks[position:end])
        position = end


def run_python(checkout: Checkout, page: str, blocks: list[Block]) -> None:
    """Run blocks of Python as one script, whose lines have the numbers that they have in the page.

    What a line prints must be in the comment behind it, if there is one.
    """
    script: list[str] = []
    for block in blocks:
        script += [""] * (block.line - 1 - len(script))
        script += block.code.splitlines()
    name = f"{Path(page).stem}_script.py"
    (checkout.folder / name).write_text("\n".join(script) + "\n", "utf-8")
    printed = checkout.run("python", "-P", name, place=page)
    for expected in PRINTED.findall("\n".join(script)):
        assert expected in printed


def test_code_blocks_are_found_in_order_and_lists_are_ignored() -> None:
    page = "# T\n\n    one\n    two\n\n- item\n\n    of the item\n\ntext\n\n```python\nx = 1\n```\n"
    assert blocks_of(page) == [Block("sh", 3, "one\ntwo"), Block("python", 13, "x = 1")]
