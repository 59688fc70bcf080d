"""Files that are found by name: nobody waits for a pipe, a device or a file without an end."""

from __future__ import annotations

import os
import resource
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import rasterio
import shapely
from rasterio import Affine

from tests.drawings import read_lines
from tests.messages import refused
from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.containment import refuse_links
from vomstudio.core.files.lock import ProjectLock
from vomstudio.core.files.regular import (
    open_regular_file,
    read_small_file,
    require_regular_siblings,
)
from vomstudio.io.control.formats.micmac import find_marks
from vomstudio.io.gis.raster import read_size_and_bands
from vomstudio.io.gis.raster_georeference import read_map_placement
from vomstudio.io.models.opening import read_model
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.verify import verify

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes have names on POSIX only")


@pytest.mark.parametrize("ending", [".tfw", ".wld", ".tif.aux.xml", ".tif.msk", ".tif.ovr", ".TFW"])
@pytest.mark.parametrize("read", [read_model, read_size_and_bands])
def test_pipe_beside_height_raster_is_refused(
    tmp_path: Path, ending: str, read: Callable[[Path], object]
) -> None:
    path = tmp_path / "a.tif"
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=8,
        height=8,
        count=1,
        dtype="float32",
        crs="EPSG:32632",
        transform=Affine(1, 0, 5e5, 0, -1, 52e5),
    ) as file:
        file.write(np.ones((1, 8, 8), np.float32))
    read(path)
    assert read_map_placement(path) is not None
    os.mkfifo(tmp_path / f"a{ending}")
    with refused("file.device-in-folder") as refusal:
        read(path)
    assert refusal.value.file == str(tmp_path / f"a{ending}")
    assert read_map_placement(path) is None


@pytest.mark.parametrize("ending", [".dbf", ".shx", ".cpg", ".prj", ".qix"])
def test_device_beside_shapefile_is_refused(tmp_path: Path, ending: str) -> None:
    lines = np.array([shapely.to_wkb(shapely.LineString([(0, 0), (3, 5)]))], object)
    pyogrio.raw.write(
        tmp_path / "a.shp",
        lines,
        [],
        [],
        geometry_type="LineString",
        driver="ESRI Shapefile",
        crs="EPSG:32633",
    )
    (tmp_path / f"a{ending}").unlink(missing_ok=True)
    (tmp_path / f"a{ending}").symlink_to("/dev/zero")
    with refused("file.device-in-folder"):
        read_lines(tmp_path / "a.shp")


def test_harmless_siblings_are_allowed(tmp_path: Path) -> None:
    """Folders, links that lead nowhere, and pipes of other names wait for nobody."""
    (tmp_path / "a.obj").write_bytes(b"v 0 0 0\n")
    (tmp_path / "a.tiles").mkdir()
    (tmp_path / "a.prj").symlink_to("nowhere")
    os.mkfifo(tmp_path / "b.prj")
    require_regular_siblings(tmp_path / "a.obj")
    require_regular_siblings(tmp_path / "none" / "a.obj")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "a.prj").open("wb") as file:
        file.truncate(1 << 36)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with refused("file.too-large", limit_mb=300):
        read_small_file(tmp_path / "a.prj", 300 << 20)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000
    (tmp_path / "b.prj").write_bytes(b"x" * 100)
    assert read_small_file(tmp_path / "b.prj", 100) == b"x" * 100
    with pytest.raises(InputError):
        read_small_file(tmp_path / "b.prj", 99)


@pytest.mark.parametrize("ending", ["-journal", "-wal", "-shm", ""])
def test_pipe_in_place_of_journal_file_is_refused(tmp_path: Path, ending: str) -> None:
    project = tmp_path / "a.vom"
    ProjectFolder.create(project).close()
    place = project / f"journal.sqlite{ending}"
    place.unlink(missing_ok=True)
    os.mkfifo(place)
    for look in (ProjectFolder.open, read_replay, verify):
        with pytest.raises(VomError, match=r"journal\.sqlite"):
            look(project)


@pytest.mark.parametrize("name", ["lock", "lock-journal", "lock-wal"])
def test_pipe_in_place_of_lock_is_replaced(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    lock = ProjectLock(tmp_path / "lock")
    lock.release()
    assert not (tmp_path / name).is_fifo()


def test_pipe_in_result_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    refuse_links(tmp_path)
    os.mkfifo(tmp_path / "work" / "database.db-journal")
    with refused("file.device-in-folder", TargetError):
        refuse_links(tmp_path)


def _sidecar(path: Path) -> object:
    from vomstudio.products.ortho.back_projection import read_sidecar

    return read_sidecar(path)


def _drawing(path: Path) -> object:
    from vomstudio.io.gis.svg_lines import read_svg

    return read_svg(path)


def _network(path: Path) -> object:
    from vomstudio.extraction.proposals.edge_network import EdgeNetwork

    return EdgeNetwork(path)


@pytest.mark.parametrize("read", [_sidecar, _drawing, _network])
@pytest.mark.parametrize("what", ["pipe", "device", "huge"])
def test_pipes_devices_and_huge_files_are_refused(
    tmp_path: Path, read: Callable[[Path], object], what: str
) -> None:
    path = tmp_path / "a.svg"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        path.symlink_to("/dev/zero")
    else:
        with path.open("wb") as file:
            file.truncate(1 << 36)
    with pytest.raises(InputError) as refusal:
        read(path)
    assert refusal.value.file == str(path)


def test_pipe_beside_control_points_is_not_used_as_marks(tmp_path: Path) -> None:
    (tmp_path / "app.xml").write_text("<DicoAppuisFlottant/>")
    (tmp_path / "marks.xml").write_text("<SetOfMesureAppuisFlottants/>")
    os.mkfifo(tmp_path / "z.xml")
    (tmp_path / "zero.xml").symlink_to("/dev/zero")
    assert find_marks(tmp_path / "app.xml") == tmp_path / "marks.xml"


def test_name_with_null_byte_is_not_found() -> None:
    with pytest.raises(FileNotFoundError):
        open_regular_file("a\0b")


def test_pipe_is_refused_by_table_and_copc_readers(
    tmp_path: Path,
) -> None:
    from vomstudio.io.models import copc
    from vomstudio.io.text.tables import read_points

    for name, read in (("a.csv", read_points), ("a.copc.laz", copc.CopcFile)):
        os.mkfifo(tmp_path / name)
        with pytest.raises(InputError, match="pipe"):
            read(tmp_path / name)
    # Whether it is streamed is asked in the thread of the window, and the reading then refuses.
    assert copc.point_count(tmp_path / "a.copc.laz") == 0
