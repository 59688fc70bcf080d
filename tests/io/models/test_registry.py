"""Finding the reader of a file, ours or somebody else's."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import InputError
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models import formats, registry
from vomstudio.io.models.formats import las, obj, xyz
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.reader import LoadedModel, Reader


@pytest.fixture(autouse=True)
def _fresh_readers() -> Iterator[None]:
    registry.find_readers.cache_clear()
    yield
    registry.find_readers.cache_clear()


def read_xyz(path: Path, progress: Progress) -> LoadedModel:
    return LoadedModel(PointCloud(np.loadtxt(path, ndmin=2, skiprows=1)), "cloud", None, (), path)


XYZ = Reader("Made-up XYZ", (".xyzq",), lambda path, head: head.startswith(b"XYZQ"), read_xyz)


def offer(monkeypatch: pytest.MonkeyPatch, *values: str) -> None:
    points = [EntryPoint(f"p{i}", value, registry.GROUP) for i, value in enumerate(values)]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: points)


def test_a_reader_of_another_package_reads_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "their_package.py").write_text(
        "import numpy as np\n"
        "from vomstudio.geometry.cloud import PointCloud\n"
        "from vomstudio.io.models.reader import LoadedModel, Reader\n"
        "def read(path, progress):\n"
        "    points = np.loadtxt(path, ndmin=2, skiprows=1)\n"
        "    return LoadedModel(PointCloud(points), 'cloud', None, (), path)\n"
        "READER = Reader('Made-up', ('.xyzq',), lambda p, h: h.startswith(b'XYZQ'), read)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    offer(monkeypatch, "their_package:READER")
    path = tmp_path / "cloud.xyzq"
    path.write_text("XYZQ\n1 2 3\n4 5 6\n")
    loaded = read_model(path)
    assert loaded.data.bounds.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert len(loaded.content_hash) == 64
    assert ".xyzq" in registry.extensions()
    path = path.rename(tmp_path / "cloud.dat")
    assert read_model(path).kind == "cloud"


def test_reader_can_be_one_module_in_the_formats_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "xyzq.py").write_text(
        "from vomstudio.io.models.reader import Reader\n"
        "READER = Reader('One file', ('.xyzq',), lambda p, h: False, None)\n"
    )
    (tmp_path / "_helper.py").write_text("raise AssertionError\n")
    monkeypatch.setattr(formats, "__path__", [*formats.__path__, str(tmp_path)])
    assert "One file" in [r.name for r in registry.find_readers().all]


def test_broken_plugin_does_not_disable_other_readers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    offer(monkeypatch)
    names = [r.name for r in registry.find_readers().all]
    assert {obj.READER.name, las.READER.name, xyz.READER.name} <= set(names)
    registry.find_readers.cache_clear()
    offer(monkeypatch, "no_such_package:READER", "math:pi")
    found = registry.find_readers()
    assert [r.name for r in found.all] == names
    assert len(found.problems) == 2
    path = tmp_path / "model.abc"
    path.write_bytes(b"?")
    with refused("file.unknown-type") as error:
        read_model(path)
    assert "no_such_package" in error.value.values["formats"]


@pytest.mark.parametrize(
    "extension", [".obj", ".ply", ".las", ".laz", ".glb", ".gltf", ".stl", ".xyz", ".csv"]
)
def test_builtin_formats_are_registered(extension: str) -> None:
    assert extension in registry.extensions()


def test_content_overrides_a_wrong_extension(tmp_path: Path) -> None:
    path = tmp_path / "really_ply.obj"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n"
    )
    assert read_model(path).kind == "cloud"
    path = tmp_path / "no_extension"
    path.write_text("# made by hand\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert read_model(path).kind == "mesh"


def test_unknown_file_is_rejected_with_a_list_of_formats(tmp_path: Path) -> None:
    path = tmp_path / "notes.docx"
    path.write_bytes(b"PK\x03\x04")
    with pytest.raises(InputError) as caught:
        read_model(path)
    for word in ("notes.docx", ".obj", ".ply", ".laz"):
        assert word in str(caught.value)


def test_default_reader_is_the_first_one_for_the_extension() -> None:
    """Which spares the import of the others must not change who reads."""
    for ending in formats.MODULES_BY_SUFFIX:
        first = next(r for r in registry.find_readers().all if ending in r.extensions)
        assert registry.default_reader(ending) is first
