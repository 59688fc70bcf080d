"""Models as cached arrays: the same model comes back, or the file is read again."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.messages import refused
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.findings import uncoded_finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models import model_cache
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.reader import LoadedModel


@pytest.fixture
def model(tmp_path: Path) -> Path:
    Image.new("RGB", (2, 2)).save(tmp_path / "tex.png")
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 .5 0\nmap_Kd tex.png\n")
    path = tmp_path / "model.obj"
    path.write_text(
        "mtllib m.mtl\nv 576665.123 5188117.456 0 1 0 0\nv 576666 5188117 0 0 1 0\n"
        "v 576666 5188118 0 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1 2 3\n"
        "usemtl a\nf 1/1 2/2 3/3\nf 1 2 8\n"
    )
    return path


def same(a: LoadedModel, b: LoadedModel) -> bool:
    assert isinstance(a.data, Mesh)
    assert isinstance(b.data, Mesh)
    for name in ("vertices", "faces", "material_offsets", "uv", "colors"):
        assert np.array_equal(getattr(a.data, name), getattr(b.data, name), equal_nan=name == "uv")
    assert a.data.materials == b.data.materials
    return (a.kind, a.crs, a.warnings, a.path, a.content_hash) == (
        b.kind,
        b.crs,
        b.warnings,
        b.path,
        b.content_hash,
    )


def test_mesh_round_trips_without_memory_mapping(model: Path, tmp_path: Path) -> None:
    loaded = read_model(model)
    model_cache.save(loaded, tmp_path / "cache" / "m")
    back = model_cache.open_cache_folder(tmp_path / "cache" / "m")
    assert same(loaded, back)
    assert isinstance(back.data, Mesh)
    assert type(back.data.vertices) is np.ndarray
    assert not back.data.vertices.flags.writeable
    assert sorted(p.name for p in (tmp_path / "cache").iterdir()) == ["m"]


def test_cloud_round_trips_with_normals_and_fields(tmp_path: Path) -> None:
    points = np.random.default_rng(0).random((7, 3))
    odd = "scalar / odd name"
    fields = {odd: np.arange(7, dtype=np.int16), "t": np.linspace(0, 1, 7)}
    cloud = PointCloud(points, None, points.astype(np.float32), fields)
    loaded = LoadedModel(
        cloud, "cloud", "EPSG:32615", (uncoded_finding("A warning."),), tmp_path / "gone.laz", "abc"
    )
    model_cache.save(loaded, tmp_path / "m")
    back = model_cache.open_cache_folder(tmp_path / "m")
    assert isinstance(back.data, PointCloud)
    assert np.array_equal(back.data.points, points)
    assert back.data.normals is not None
    assert list(back.data.fields) == list(fields)
    assert back.data.fields[odd].dtype == np.int16
    assert back.crs == "EPSG:32615"


def test_second_load_uses_cache_and_changed_file_is_reread(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "cache"
    first = model_cache.load(model, folder)
    calls: list[Path] = []

    def counted(path: Path, progress: object = None) -> LoadedModel:
        calls.append(path)
        return read_model(path)

    monkeypatch.setattr(model_cache, "read_model", counted)
    assert same(first, model_cache.load(model, folder))
    model.touch()
    assert same(first, model_cache.load(model, folder))
    assert calls == []
    model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert len(model_cache.load(model, folder).data.bounds) == 2
    assert calls == [model]


def damage_meta(folder: Path, **changes: object) -> None:
    meta = json.loads((folder / "meta.json").read_text())
    meta.update(changes)
    (folder / "meta.json").write_text(json.dumps(meta))


def shorten(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-8])


def lengthen(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\0" * 100_000)


DAMAGE = {
    "no meta": lambda f: (f / "meta.json").unlink(),
    "cut meta": lambda f: shorten(f / "meta.json"),
    "meta is a list": lambda f: (f / "meta.json").write_text("[]"),
    "version": lambda f: damage_meta(f, version=99),
    "kind": lambda f: damage_meta(f, kind="cake"),
    "no arrays": lambda f: damage_meta(f, arrays={}),
    "arrays is a number": lambda f: damage_meta(f, arrays=3),
    "path out": lambda f: damage_meta(f, arrays={"../x": {"shape": [1], "dtype": "<f8"}}),
    "objects": lambda f: damage_meta(f, arrays={"vertices": {"shape": [3, 3], "dtype": "|O"}}),
    "materials": lambda f: damage_meta(f, materials=[]),
    "material without keys": lambda f: damage_meta(f, materials=[{}, {}]),
    "short array": lambda f: shorten(f / "vertices.npy"),
    "long array": lambda f: lengthen(f / "vertices.npy"),
    "no array": lambda f: (f / "faces.npy").unlink(),
    "empty array": lambda f: (f / "faces.npy").write_bytes(b""),
    "wild faces": lambda f: np.save(f / "faces.npy", np.full((2, 3), 77, np.int32)),
    "other shape": lambda f: np.save(f / "uv.npy", np.zeros((9, 2), np.float32)),
    "other type": lambda f: np.save(f / "vertices.npy", np.zeros((3, 3), np.float32)),
    "columns first": lambda f: np.save(f / "colors.npy", np.zeros((3, 3), np.uint8, order="F")),
    "pickle": lambda f: np.save(f / "uv.npy", np.array([{}] * 3, object), allow_pickle=True),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damaged_cache_is_rejected_and_rebuilt(model: Path, tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "cache"
    first = model_cache.load(model, folder)
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    DAMAGE[kind](copy)
    with pytest.raises(InputError):
        model_cache.open_cache_folder(copy)
    assert same(first, model_cache.load(model, copy))
    model_cache.open_cache_folder(copy)


def test_missing_texture_is_dropped_with_a_warning(model: Path, tmp_path: Path) -> None:
    model_cache.load(model, tmp_path / "cache")
    (tmp_path / "tex.png").unlink()
    back = model_cache.open_cache_folder(tmp_path / "cache")
    assert isinstance(back.data, Mesh)
    assert [m.texture for m in back.data.materials] == [None, None]
    assert back.warnings[-1].code == "texture.unusable"


def test_unwritable_cache_is_rejected_and_loading_continues(model: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(TargetError):
        model_cache.save(read_model(model), tmp_path / "file" / "cache")
    assert model_cache.load(model, tmp_path / "file" / "cache").kind == "mesh"


def test_model_with_unwritable_cache_is_transferred_through_temporary_files(
    model, tmp_path, monkeypatch
):
    monkeypatch.setattr(model_cache.tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    (tmp_path / "cache").write_text("in the way")
    loaded, folder = model_cache.load_for_transfer(model, tmp_path / "cache" / "model-1")
    assert folder.is_relative_to(tmp_path / "temporary")
    assert len(model_cache.read_transfer_folder(folder).data.faces) == len(loaded.data.faces)
    assert list((tmp_path / "temporary").iterdir()) == []
    (tmp_path / "temporary").rmdir()
    with refused("model.cache-unwritable", TargetError):
        model_cache.load_for_transfer(model, tmp_path / "cache" / "model-1")


def test_transferred_cache_is_kept(model, tmp_path):
    _, folder = model_cache.load_for_transfer(model, tmp_path / "cache" / "model-1")
    model_cache.read_transfer_folder(folder)
    assert folder == tmp_path / "cache" / "model-1"
    model.unlink()
    model_cache.read_transfer_folder(folder)
