"""The documents name what there is: modules, functions, commands, options, files, pictures."""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.architecture import finding_codes
from tests.architecture.test_examples import NEW
from tests.pictures_maker import maker
from vomstudio.cli import COMMANDS
from vomstudio.cli.common.entry import build_parser
from vomstudio.project.tables.orientation_table import COLUMNS
from vomstudio.ui.dialogs.help.help_pages import anchor

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
DOCUMENTS = [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
MODULE_PATH = re.compile(
    r"(?<![\w/.])((?:vomstudio|tests|packaging|resources|docs|\.ci)/[\w./-]*\w/?)"
)
DOTTED = re.compile(r"`(vomstudio(?:\.\w+)+)")
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
CODE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
OPTION = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
LARGEST_PICTURE_BYTES = 150_000
FIGURE_COLUMNS = re.compile(
    r"columns of the orientation table,\s+in\s+this\s+order:\n\n(.*?)\.\n", re.DOTALL
)

each_document = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)


# --- modules and files ----------------------------------------------------------------------------
@each_document
def test_every_path_in_documents_exists(document: Path) -> None:
    text = document.read_text("utf-8")
    examples = {name for name, _ in NEW.findall(text)}
    missing = [
        name
        for name in sorted(set(MODULE_PATH.findall(text)))
        if name not in examples and not (ROOT / name).exists()
    ]
    assert missing == []


@each_document
def test_every_module_in_documents_exists(document: Path) -> None:
    missing = [name for name in DOTTED.findall(document.read_text("utf-8")) if not _is_there(name)]
    assert missing == []


def _is_there(dotted: str) -> bool:
    """A package, a module, something that a module defines, or a group of entry points."""
    if f'"{dotted}"' in (ROOT / "pyproject.toml").read_text("utf-8"):
        return True
    path = ROOT / dotted.replace(".", "/")
    if path.is_dir() or path.with_suffix(".py").is_file():
        return True
    owner, _, name = dotted.rpartition(".")
    module = (ROOT / owner.replace(".", "/")).with_suffix(".py")
    return module.is_file() and name in _defined(module)


def _defined(module: Path) -> set[str]:
    """Functions, classes, and members of classes of a module; names that its top gives a value."""
    found: set[str] = set()
    for node in ast.parse(module.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{d.name}" for d in node.body if isinstance(d, ast.FunctionDef)}
        if isinstance(node, ast.Assign):
            found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            found.add(node.target.id)
    return found


def test_every_step_of_architecture_walkthroughs_names_existing_function() -> None:
    page = (DOCS / "architecture.md").read_text("utf-8")
    steps = re.findall(r"\| `(vomstudio/[\w/]+\.py)` \| `([\w.]+)`", page)
    assert len(steps) >= 40
    assert [step for step in steps if step[1] not in _defined(ROOT / step[0])] == []


# --- links and pictures ---------------------------------------------------------------------------
@each_document
def test_every_link_resolves(document: Path) -> None:
    text = CODE.sub("", document.read_text("utf-8"))
    broken = []
    for target in LINK.findall(text):
        if re.match(r"https?://", target):
            continue
        name, _, heading = target.partition("#")
        path = document if not name else document.parent / name
        if not path.is_file() or (heading and heading not in _anchors(path)):
            broken.append(target)
    assert broken == []


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", CODE.sub("", page.read_text("utf-8")), re.MULTILINE)
    return {anchor(heading.replace("`", "")) for heading in headings}


def test_links_between_pages_stay_in_docs_folder() -> None:
    """Help has no other file, nor has the site."""
    outside = [
        (page.name, target)
        for page in PAGES
        for target in LINK.findall(CODE.sub("", page.read_text("utf-8")))
        if target.startswith("..")
    ]
    assert outside == []


def test_pictures_are_small_and_all_of_them_are_shown() -> None:
    shown = {
        (document.parent / target).resolve()
        for document in DOCUMENTS
        for target in re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", document.read_text("utf-8"))
    }
    kept = {path.resolve() for path in (DOCS / "pictures").iterdir()}
    assert shown == kept
    assert [p.name for p in kept if p.stat().st_size > LARGEST_PICTURE_BYTES] == []


def test_every_picture_has_alt_text() -> None:
    silent = [
        document.name
        for document in DOCUMENTS
        for words in re.findall(r"!\[([^\]]*)\]", document.read_text("utf-8"))
        if len(words.split()) < 3
    ]
    assert silent == []


def test_layer_picture_matches_import_contracts() -> None:
    kept = (DOCS / "pictures" / "layers.svg").read_text("utf-8")
    assert kept == maker("layers").drawn(), "run packaging/make_pictures --only layers"


# --- the command line -----------------------------------------------------------------------------
def _sections() -> dict[str, str]:
    """The text of each command's section, by its words: "fit", "project undo"."""
    page = (DOCS / "cli.md").read_text("utf-8")
    parts = re.split(r"^##+ (.+)$", page, flags=re.MULTILINE)[1:]
    return {
        title.removeprefix("vomstudio ").replace(" PROJECT ", " "): text
        for title, text in zip(parts[::2], parts[1::2], strict=True)
        if title.startswith("vomstudio ")
    }


def _commands() -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for name, parser in _inner(build_parser(())):
        yield name, parser
        yield from ((f"{name} {action}", inner) for action, inner in _inner(parser))


def _inner(parser: argparse.ArgumentParser) -> list[tuple[str, argparse.ArgumentParser]]:
    found = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    return [item for action in found for item in action.choices.items()]


SHARED = {"--json", "--progress", "--quiet", "-q", "--verbose", "-v", "--help", "-h"}


def test_cli_page_documents_exactly_the_existing_commands() -> None:
    assert [name for name in _sections() if " " not in name] == list(COMMANDS)
    assert set(_sections()) == {name for name, _ in _commands()}


@pytest.mark.parametrize("command", [name for name, _ in _commands()])
def test_cli_page_documents_exactly_the_options_of_a_command(command: str) -> None:
    parser = dict(_commands())[command]
    documented, options = _documented(command), _options(parser) - SHARED
    if command == "project accept":
        # The options of a search are described by its own command.
        every = {option for nested in _subparsers(parser) for option in _options(nested)}
        assert documented <= every
        assert every - SHARED <= documented | _documented("facets") | _documented("trace")
        return
    assert documented == options


def _options(parser: argparse.ArgumentParser) -> set[str]:
    return {word for action in parser._actions for word in action.option_strings}


def _subparsers(parser: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    choices = [a.choices for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    return [each for found in choices for each in found.values()]


def _documented(command: str) -> set[str]:
    code = " ".join(re.findall(r"`([^`]+)`", CODE.sub("", _sections()[command])))
    return set(OPTION.findall(code))


# They need a project with something wrong.
WITHOUT_EXAMPLE = {"project update", "project repair"}


def test_every_command_has_an_example_on_the_page() -> None:
    """tests/architecture/test_document_commands.py runs them."""
    missing = set()
    for command, text in _sections().items():
        start = "vomstudio " + command.replace("project ", r"project \S+ ")
        if not re.search(rf"^    {start}\b", text, re.MULTILINE):
            missing.add(command)
    assert missing - {"project"} == WITHOUT_EXAMPLE


def test_the_page_names_the_options_that_all_commands_share() -> None:
    page = (DOCS / "cli.md").read_text("utf-8")
    shared = page[page.index("## Rules") : page.index("## vomstudio demo")]
    assert SHARED - {"-h"} <= set(OPTION.findall(shared))


def test_the_page_lists_the_columns_of_the_orientation_table_in_their_order() -> None:
    listed = FIGURE_COLUMNS.search((DOCS / "cli.md").read_text("utf-8"))
    assert listed is not None
    assert tuple(re.findall(r"`(\w+)`", listed.group(1))) == COLUMNS


def test_projects_page_states_current_schema_version() -> None:
    from vomstudio.project.journal.migration import SCHEMA_VERSION

    page = " ".join((ROOT / "docs" / "projects.md").read_text(encoding="utf-8").split())
    assert f"(schema {SCHEMA_VERSION})" in page


def test_findings_page_is_up_to_date() -> None:
    """``python -m tests.architecture.finding_codes`` writes the table."""
    page = finding_codes.PAGE.read_text("utf-8")
    assert finding_codes.renewed(page) == page
