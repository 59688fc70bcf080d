"""Where the program opens files for reading, by its own text.

Whoever packs a folder chooses what lies under its names, and a pipe or device holds up whoever
opens it. So what is read is opened by `vomstudio/core/files/regular.py`, which waits for nothing;
libraries that open names themselves are called where it has been asked about the name.

Print what breaks that with `python -m tests.architecture.opens`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "vomstudio"
HOUSE = "core/files/regular.py"
ALLOWED = {
    "core/failures/": "is below core/files and reads what the program wrote into its own folder",
    "core/files/atomic.py": "flushes what it has just made",
    "photogrammetry/base/checkpoints.py": "flushes what it has just made",
    "project/journal/file_watch.py": "keeps a descriptor of the journal that SQLite has opened",
    "project/journal/connection.py": "keeps a descriptor of the index that SQLite has opened",
}
"""Who opens by name himself, and why. Folders end in a stroke."""
LIBRARIES = {
    "np.load",
    "np.genfromtxt",
    "np.fromfile",
    "np.memmap",
    "shutil.copy",
    "shutil.copy2",
    "shutil.copyfile",
    "shutil.copytree",
    "zipfile.ZipFile",
    "tarfile.open",
    "Image.open",
    "rasterio.open",
    "laspy.open",
    "libe57.ImageFile",
    "cv2.imread",
    "cv2.VideoCapture",
    "pyogrio.read_info",
    "pyogrio.list_layers",
    "QImageReader",
    "QMovie",
}
"""Calls that open what is named to them; SQLite waits for a pipe only where it may not write."""
ASKS = {"is_file", "refuse_links", "special_files", "readable_layers"}
"""Who asks about names besides the functions of the house: in folders, and before GDAL."""
_MODE = re.compile(r"[rwaxbt+]{1,4}")


def _dotted(node: ast.expr) -> str:
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    return ""


def _mode(call: ast.Call, at: int) -> str | None:
    """That a call of `open` states in its place `at`; None where it states none."""
    named = [word.value for word in call.keywords if word.arg == "mode"]
    for given in (*call.args[at : at + 1], *named):
        if isinstance(given, ast.Constant) and _MODE.fullmatch(str(given.value)):
            return str(given.value)
    return None


def _reads(call: ast.Call) -> bool:
    """Whether a call opens a file by its name, other than to write one anew."""
    name = _dotted(call.func)
    if name in ("os.open", "io.open"):
        return "os.devnull" not in ast.unparse(call)
    if name == "open":
        return not set(_mode(call, 1) or "r") & set("wax")
    if not isinstance(call.func, ast.Attribute):
        return False
    if call.func.attr in ("read_text", "read_bytes"):
        return True
    if call.func.attr != "open":
        return False
    stated = _mode(call, 0)
    worded = {word.arg for word in call.keywords} & {"encoding", "buffering", "newline", "errors"}
    return not set(stated) & set("wax") if stated else bool(worded) and not call.args


def _opens_a_name(call: ast.Call) -> bool:
    """Whether a library opens for reading what is named to it."""
    name = _dotted(call.func)
    if name == "sqlite3.connect":
        return "mode=ro" in ast.unparse(call)
    mode = _mode(call, 1)
    return name in LIBRARIES and not (mode is not None and set(mode) & set("wax"))


def _house(root: Path) -> set[str]:
    tree = ast.parse((root / PACKAGE / HOUSE).read_text("utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@cache
def calls_in(text: str) -> list[ast.Call]:
    return [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]


def unasked(root: Path = ROOT, allowed: Iterable[str] = tuple(ALLOWED)) -> Iterator[str]:
    """A line for each call that opens a file without having asked what it is."""
    excused = tuple(allowed)
    asks = _house(root) | ASKS
    for path in sorted((root / PACKAGE).rglob("*.py")):
        name = path.relative_to(root / PACKAGE).as_posix()
        if name == HOUSE or name.startswith(excused):
            continue
        calls = calls_in(path.read_text("utf-8"))
        asked = any(_dotted(call.func).rpartition(".")[2] in asks for call in calls)
        for call in calls:
            if _reads(call) or (_opens_a_name(call) and not asked):
                yield f"{name}:{call.lineno}: {ast.unparse(call)[:80]}"


if __name__ == "__main__":
    print("\n".join(unasked()))
