"""Tables generated from the code: options in `docs/cli.md`, operations and packages in
`docs/architecture.md`, and all modules in `docs/modules.md`.

``python -m tests.architecture.operation_tables`` renews them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from pathlib import Path

from vomstudio.cli.common.declared_options import help_text, metavar
from vomstudio.core.operations import INTERFACES
from vomstudio.core.options import Declaration, declarations
from vomstudio.studio.operations import OPERATIONS
from vomstudio.studio.project_options import ACTION_OPTIONS

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
COMMANDS, ARCHITECTURE = DOCS / "cli.md", DOCS / "architecture.md"
MODULES = DOCS / "modules.md"
MODULES_BEGIN, MODULES_END = "<!-- modules -->\n", "<!-- end of modules -->"
DOORS_BEGIN, DOORS_END = "<!-- doors -->\n", "<!-- end of doors -->"
PACKAGES_BEGIN, PACKAGES_END = "<!-- packages -->\n", "<!-- end of packages -->"


def renewed_commands(page: str) -> str:
    """Return the page with today's rows of all declared options."""
    sections = {
        f"\n## vomstudio {command}\n": _options_of(command)
        for command in dict.fromkeys(each.command_name for each in OPERATIONS)
    }
    for action, options in ACTION_OPTIONS.items():
        sections[f"\n### vomstudio project PROJECT {action}\n"] = declarations(options)
    for heading, declared in sections.items():
        start = page.index(heading) + len(heading)
        following = re.search(r"\n##+ ", page[start:])
        end = len(page) if following is None else start + following.start()
        page = page[:start] + _with_rows(page[start:end], declared) + page[end:]
    return page


def _options_of(command: str) -> tuple[Declaration, ...]:
    """Return the options of all operations of a command, each once."""
    declared = {
        each.flag: each
        for operation in OPERATIONS
        if operation.command_name == command
        for options in (*operation.options, *operation.command_options)
        for each in declarations(options)
    }
    return tuple(declared.values())


def _with_rows(section: str, declared: Sequence[Declaration]) -> str:
    if not declared:
        return section
    flags = {each.flag for each in declared}
    lines = section.split("\n")
    first = next((k for k, line in enumerate(lines) if _flag(line) in flags), None)
    if first is None:
        first = next(k for k, line in enumerate(lines) if line.startswith("|---")) + 1
    kept = [line for line in lines if _flag(line) not in flags]
    place = first - sum(_flag(line) in flags for line in lines[:first])
    return "\n".join([*kept[:place], *map(_row, declared), *kept[place:]])


def _flag(line: str) -> str | None:
    """Return the first option that a row of a table describes."""
    match = re.match(r"\| `(--[a-z0-9-]+)", line)
    return None if match is None else match[1]


def _row(option: Declaration) -> str:
    word = option.flag
    if option.choices is not None:
        word += f" {'|'.join(option.choices)}".replace("|", "\\|")
    elif option.kind is bool and option.default is None:
        word += f"`, `--no-{option.flag.removeprefix('--')}"
    elif option.kind is not bool:
        value = metavar(option).replace("|", "\\|")
        word += f" [{value}]" if option.flag_value else f" {value}"
    text = re.sub(
        r"--[a-z][a-z-]*(?: [a-z]+(?= [0-9]))?|NAME\w*\.\w+", r"`\g<0>`", help_text(option)
    )
    return f"| `{word}` | {text} |"


def renewed_architecture(page: str) -> str:
    """Return the page with today's tables of packages and of operations and doors."""
    tables = (
        (PACKAGES_BEGIN, PACKAGES_END, packages_table()),
        (DOORS_BEGIN, DOORS_END, doors_table()),
    )
    for begin, end, table in tables:
        start = page.index(begin) + len(begin)
        page = page[:start] + table + page[page.index(end) :]
    return page


def packages_table() -> str:
    """Return the table of all packages with the first lines of their docstrings."""
    rows = ["| package | contents |", "|---|---|"]
    for module in sorted((ROOT / "vomstudio").rglob("__init__.py")):
        package = module.parent.relative_to(ROOT / "vomstudio").as_posix()
        text = ast.get_docstring(ast.parse(module.read_text("utf-8"))) or ""
        summary = " ".join(text.partition("\n\n")[0].split()).rstrip(".")
        if package != ".":
            rows.append(f"| `{package}` | {summary} |")
    return "\n".join(rows) + "\n"


def renewed_modules(page: str) -> str:
    """Return the page with today's tables of the modules of each package."""
    sections = []
    for package in sorted((ROOT / "vomstudio").rglob("__init__.py")):
        rows = list(filter(None, map(_module_row, sorted(package.parent.glob("*.py")))))
        if rows:
            name = package.parent.relative_to(ROOT).as_posix()
            table = ["| module | contents | defines |", "|---|---|---|", *rows]
            sections.append(f"## {name}\n\n" + "\n".join(table) + "\n")
    start = page.index(MODULES_BEGIN) + len(MODULES_BEGIN)
    return page[:start] + "\n".join(sections) + page[page.index(MODULES_END) :]


def _module_row(module: Path) -> str | None:
    """Return the row of a module, or None for an `__init__.py` that defines nothing."""
    tree = ast.parse(module.read_text("utf-8"))
    text = ast.get_docstring(tree) or ""
    summary = " ".join(text.partition("\n\n")[0].split()).rstrip(".").replace("|", "\\|")
    names = list(dict.fromkeys(filter(_is_public, map(_defined_name, tree.body))))
    if module.name == "__init__.py" and not names:
        return None
    return f"| `{module.name}` | {summary} | {', '.join(f'`{name}`' for name in names)} |"


def _defined_name(node: ast.stmt) -> str:
    """Return the name of a function, class or constant, or an empty string."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return node.name
    if isinstance(node, ast.AnnAssign):
        return ast.unparse(node.target)
    if isinstance(node, ast.Assign) and len(node.targets) == 1:
        return ast.unparse(node.targets[0])
    return ""


def _is_public(name: str) -> bool:
    return name.isidentifier() and not name.startswith("_")


def doors_table() -> str:
    """Return the table of operations against doors; a missing door has its reason."""
    rows = [f"| operation | {' | '.join(INTERFACES)} |", "|---" * (len(INTERFACES) + 1) + "|"]
    for each in OPERATIONS:
        present = {
            "command": f"`{each.command_name}`",
            "function": f"`vs.{each.function}`" if each.function else "",
            "window": f"`{each.window.rpartition('.')[2]}`" if each.window else "",
            "project method": f"`.{each.method}`" if each.method else "",
            "project command": f"`project … {each.action}`" if each.action else "",
        }
        cells = [present[door] or f"– {each.missing.get(door, '')}" for door in INTERFACES]
        cells = [
            f"– {each.missing[door]}" if door in each.missing else cell
            for door, cell in zip(INTERFACES, cells, strict=True)
        ]
        rows.append(f"| {each.name} | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    for path, renewed in (
        (COMMANDS, renewed_commands),
        (ARCHITECTURE, renewed_architecture),
        (MODULES, renewed_modules),
    ):
        path.write_text(renewed(path.read_text("utf-8")), "utf-8")
