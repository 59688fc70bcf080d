"""Catalogues of other languages: made from the code, found, and harmless when they are damaged."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_dir
from babel.messages.mofile import write_mo

from vomstudio.cli import main
from vomstudio.core.languages import use_user_language
from vomstudio.core.words import tr, use_catalogue

ROOT = Path(__file__).resolve().parents[1]
KEYWORDS = {
    **dict.fromkeys(("tr", "to_translate", "_")),
    **dict.fromkeys(("tr_n", "to_translate_n"), (1, 2)),
}


@pytest.fixture(autouse=True)
def english(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in ("VOMSTUDIO_LANGUAGE", "LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    yield
    use_catalogue(None)


@cache
def extracted() -> tuple[str | tuple[str, ...], ...]:
    found = extract_from_dir(ROOT / "vomstudio", [("**.py", "python")], keywords=KEYWORDS)
    return tuple(message for _, _, message, _, _ in found)


def german(folder: Path) -> Path:
    """A catalogue in which every string of the program is put between asterisks."""
    catalogue = Catalog(locale="de")
    for message in extracted():
        if isinstance(message, tuple):
            catalogue.add(message, tuple(f"*{text}*" for text in message))
        else:
            catalogue.add(message, f"*{message}*")
    path = folder / "de" / "LC_MESSAGES" / "vomstudio.mo"
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        write_mo(file, catalogue)
    return path


@pytest.mark.full
def test_all_strings_can_be_extracted_from_the_code() -> None:
    assert len(set(extracted())) > 1000


def test_translated_messages_reach_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    german(tmp_path)
    monkeypatch.setenv("LANG", "de_AT.UTF-8")
    use_user_language(tmp_path)
    assert main(["fit", str(tmp_path / "none.csv")]) == 2
    said = capfd.readouterr().err.strip()
    assert "*" in said
    assert said.endswith("*")
    use_catalogue(None)
    assert main(["fit", str(tmp_path / "none.csv")]) == 2
    assert capfd.readouterr().err.strip() == said.replace("*", "")


@pytest.mark.parametrize(
    ("name", "wish"),
    [("LANGUAGE", "xx:de:fr"), ("LC_ALL", "de"), ("VOMSTUDIO_LANGUAGE", "de_CH")],
)
def test_language_follows_the_usual_environment_variables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, wish: str
) -> None:
    german(tmp_path)
    some = next(
        message for message in extracted() if isinstance(message, str) and "{" not in message
    )
    monkeypatch.setenv("LANG", "fr")
    monkeypatch.setenv(name, wish)
    use_user_language(tmp_path)
    assert tr(some) == f"*{some}*"


@pytest.mark.parametrize("wish", ["", "C", "C.UTF-8", "fr_FR.UTF-8"])
def test_missing_catalogue_falls_back_to_english(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wish: str
) -> None:
    german(tmp_path)
    monkeypatch.setenv("LANG", wish)
    use_user_language(tmp_path)
    assert tr("Cancelled.") == "Cancelled."


@pytest.mark.parametrize("content", [b"", b"rubbish", b"\xde\x12\x04\x95", None])
def test_damaged_catalogue_falls_back_to_english(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes | None
) -> None:
    path = german(tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if content is None else content)
    monkeypatch.setenv("LANG", "de")
    use_user_language(tmp_path)
    assert tr("Cancelled.") == "Cancelled."


def test_only_english_is_shipped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LANG", "de")
    use_user_language()
    assert tr("Cancelled.") == "Cancelled."
