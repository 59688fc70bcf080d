"""A LAZ file of which a part is blank, as a memory card leaves it, is refused by its place."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import laspy
import numpy as np
import pytest

from tests.messages import shown_codes
from tests.tiers import first_in_default_tier

READ = """
import sys
from pathlib import Path
from vomstudio.core.errors import InputError
from vomstudio.io.models.opening import read_model
try:
    print(len(read_model(Path(sys.argv[1])).data.points))
except InputError as error:
    print(error)
"""


@pytest.mark.parametrize("format_", first_in_default_tier([1, 3, 7], 1))
def test_blank_section_does_not_crash_the_process(format_: int, tmp_path: Path) -> None:
    chance = np.random.default_rng(4)
    cloud = laspy.LasData(laspy.LasHeader(version="1.4", point_format=format_))
    cloud.header.scales = [0.001] * 3
    cloud.x, cloud.y, cloud.z = (chance.random((6000, 3)) * 40).T
    cloud.intensity = np.full(6000, 65535)
    cloud.gps_time = np.arange(6000) * 1e-3
    path = tmp_path / "a.laz"
    cloud.write(path)
    whole = path.read_bytes()
    said = []
    for length in (0, 100, 4096):
        data = bytearray(whole)
        data[10_000 : 10_000 + length] = b"\xff" * length
        path.write_bytes(bytes(data))
        # In a process of its own, which it would take with it.
        done = subprocess.run(
            [sys.executable, "-c", READ, str(path)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        said.append(done.stdout.strip())
    assert said[0] == "6000"
    assert "a.laz" in said[2]
    assert "file.blank" in shown_codes(said[2])
    assert abs(int(said[2].partition("byte ")[2].partition(")")[0]) - 10_001) < 3


@pytest.mark.parametrize("block", [256, 1000])
def test_blank_section_is_found_at_any_block_boundary(
    block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vomstudio.core.errors import InputError
    from vomstudio.core.progress import SilentProgress
    from vomstudio.io.models.formats import _las_header

    monkeypatch.setattr(_las_header, "BLOCK_BYTES", block)
    cloud = laspy.LasData(laspy.LasHeader(version="1.2", point_format=0))
    cloud.x, cloud.y, cloud.z = (np.random.default_rng(4).random((900, 3)) * 40).T
    path = tmp_path / "a.laz"
    cloud.write(path)
    whole = path.read_bytes()
    begin = int.from_bytes(whole[96:100], "little")
    _las_header.refuse_blank(path, SilentProgress())
    for at in range(begin, begin + 3 * block, 7):
        for length, refused in ((127, False), (128, True), (2 * block + 128, True)):
            data = bytearray(whole)
            # Sound bytes around it, so that it is exactly as long as that.
            data[at - 1 : at + length + 1] = b"\0" + b"\xff" * length + b"\0"
            path.write_bytes(data)
            if refused:
                with pytest.raises(InputError) as error:
                    _las_header.refuse_blank(path, SilentProgress())
                assert (error.value.code, error.value.values) == ("file.blank", {"byte": at + 1})
            elif at > begin:
                _las_header.refuse_blank(path, SilentProgress())
