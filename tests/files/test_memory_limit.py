"""The last net under the readers: a process of ours gets no more than a file can be worth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="no other system can hold a process to it"
)

_PROGRAM = """
import sys
from pathlib import Path
import numpy as np
from vomstudio.files import memory_limit

def fits(mb):
    try:
        return len(np.zeros(mb << 20, np.uint8)) > 0
    except MemoryError:
        return False

path = Path(sys.argv[1])
if sys.argv[2] == "ours":
    memory_limit.take_charge()
with memory_limit.limited_by(path):
    found = [fits(mb) for mb in (500, 1500, 4000)]
    with memory_limit.limited_by(path):
        pass
    found.append(fits(4000))
print(*found, fits(4000))
"""


def fits(path: Path, whose: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, str(path), whose],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()


def test_a_process_of_ours_is_held_to_what_the_file_can_be_worth(tmp_path: Path) -> None:
    small, larger = tmp_path / "a.las", tmp_path / "b.las"
    small.write_bytes(b"LASF" * 100)
    larger.write_bytes(bytes(8 << 20))
    assert fits(small, "ours") == "True False False False True"
    assert fits(larger, "ours") == "True True False False True"


def test_a_script_of_a_user_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "a.las").write_bytes(b"LASF" * 100)
    assert fits(tmp_path / "a.las", "a script's") == "True True True True True"


def test_what_lies_beside_a_gltf_counts(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text("{}")
    assert fits(tmp_path / "a.gltf", "ours") == "True False False False True"
    (tmp_path / "a.bin").write_bytes(bytes(8 << 20))
    assert fits(tmp_path / "a.gltf", "ours") == "True True False False True"
