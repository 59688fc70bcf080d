"""Halves of characters in a project's texts, as names of files leave them whose bytes are no UTF-8,
on their way into files."""

from __future__ import annotations

from pathlib import Path

import pyogrio
import pytest

from tests.specimens.figures import command, copy_of, open_project
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = copy_of("schema1", tmp_path_factory.mktemp("halves"))
    opened = open_project(folder)
    session = opened.session
    traces = [each.id for each in session.of(Trace)]
    odd = edits.set_attributes(session.records, traces, notes="a\ud800b", set_name="s\udce9t")
    session.apply(odd)
    session.save()
    opened.close()
    return folder


@pytest.mark.parametrize("form", ["csv", "gpkg", "shp", "geojson", "dxf", "gempy", "gems"])
def test_text_with_surrogates_is_exported_in_every_format(
    project: Path, tmp_path: Path, form: str
) -> None:
    code, said = command("export", project, "--to", form, "-o", tmp_path / f"o.{form}")
    assert code == 0, said
    assert [Path(name).read_bytes() for name in said["files"]]


def test_surrogates_are_replaced_by_question_marks(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.gpkg"
    assert command("export", project, "--to", "gpkg", "-o", out)[0] == 0
    texts: dict[str, set[object]] = {"notes": set(), "set": set()}
    for layer, kind in pyogrio.list_layers(out):
        if kind is None:
            continue
        about, _, _, columns = pyogrio.raw.read(out, layer=layer, read_geometry=False)
        for name, values in zip(about["fields"], columns, strict=True):
            texts.setdefault(str(name), set()).update(values.tolist())
    assert "a?b" in texts["notes"]
    assert "s?t" in texts["set"]
