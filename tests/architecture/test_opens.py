"""What is read is opened by the one module that waits for no pipe and no device."""

from __future__ import annotations

from pathlib import Path

from tests.architecture import opens
from tests.architecture.opens import PACKAGE, ROOT


def test_files_are_opened_only_after_checking_their_type() -> None:
    found = list(opens.unasked())
    assert not found, "\n" + "\n".join(found)


def test_allowed_exceptions_exist_and_are_needed() -> None:
    for name in opens.ALLOWED:
        assert (ROOT / PACKAGE / name).exists(), name
        allowed = {k: v for k, v in opens.ALLOWED.items() if k != name}
        assert any(line.startswith(name) for line in opens.unasked(allowed=allowed)), name


def test_every_kind_of_file_opening_is_detected(tmp_path: Path) -> None:
    (tmp_path / PACKAGE / "core" / "files").mkdir(parents=True)
    (tmp_path / PACKAGE / opens.HOUSE).write_text("def open_regular(path): return open(path)")
    lines = [
        "open(p)",
        "open(p, 'rb')",
        "open(p, mode='rb')",
        "open(p, 'r+b')",
        "p.open('rb')",
        "p.open(encoding='utf-8')",
        "p.read_text()",
        "f().read_bytes()",
        "os.open(p, os.O_RDONLY)",
        "np.load(p)",
        "shutil.copyfile(p, q)",
        "rasterio.open(p)",
        "sqlite3.connect('file:p?mode=ro', uri=True)",
    ]
    fine = [
        "open(p, 'wb')",
        "p.open('w', newline='')",
        "dialog.open()",
        "Project.open(folder)",
        "rasterio.open(p, 'w')",
        "laspy.open(f, mode='w')",
        "sqlite3.connect(p)",
        "os.open(os.devnull, os.O_WRONLY)",
    ]
    (tmp_path / PACKAGE / "a.py").write_text("\n".join(lines + fine))
    found = [line.split(": ")[0] for line in opens.unasked(tmp_path)]
    assert found == [f"a.py:{number}" for number in range(1, len(lines) + 1)]
    (tmp_path / PACKAGE / "a.py").write_text("open_regular(p)\nnp.load(p)\np.read_text()")
    assert [line.split(": ")[0] for line in opens.unasked(tmp_path)] == ["a.py:3"]
