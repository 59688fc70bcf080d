"""Pictures are written and read beside COLMAP in whatever order the libraries were imported.

Each order has a process of its own, since a library is loaded once, and a limit of time, since a
clash may hang.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.tiers import first_in_default_tier

LONGEST_S = 120
OURS = "import vomstudio.photogrammetry"
PICTURES = """
import gzip, io, random
from PIL import Image

noise = random.Random(1).randbytes(3 * 400 * 300)
picture = Image.frombytes("RGB", (400, 300), noise)
for name, more in (
    ("PNG", {}), ("TIFF", {"compression": "tiff_adobe_deflate"}), ("TIFF", {"compression": "raw"}),
    ("JPEG", {"quality": 95}),
):
    file = io.BytesIO()
    picture.save(file, name, **more)
    file.seek(0)
    again = Image.open(file)
    again.load()
    assert (again.format, again.size) == (name, (400, 300))
    if name != "JPEG":
        assert again.tobytes() == noise
assert gzip.decompress(gzip.compress(noise)) == noise
"""
COLMAP = """
import pycolmap
pixels = pycolmap.Bitmap(8, 6, True)
assert (pixels.width, pixels.height) == (8, 6)
"""


@pytest.mark.parametrize(
    "parts",
    first_in_default_tier(
        [
            pytest.param((OURS, COLMAP, PICTURES), id="colmap first"),
            pytest.param((OURS, PICTURES, COLMAP, PICTURES), id="Pillow first"),
            pytest.param(
                ("from PIL import Image", OURS, COLMAP, PICTURES), id="Pillow before ours"
            ),
            pytest.param(
                (
                    "from vomstudio.photogrammetry.base.colmap import colmap",
                    "assert colmap().logging.minloglevel == 3",
                    PICTURES,
                    COLMAP,
                ),
                id="by our own way to colmap",
            ),
        ]
    ),
)
def test_pictures_can_be_read_together_with_colmap(parts: tuple[str, ...]) -> None:
    ran = subprocess.run(
        [sys.executable, "-c", "\n".join((*parts, "print('all there')"))],
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == "all there"


def test_import_order_loads_no_heavy_libraries() -> None:
    heavy = {"pycolmap", "pyceres", "cv2", "open3d", "rasterio", "scipy", "numba", "vtkmodules"}
    code = f"import sys\n{OURS}\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}))"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=LONGEST_S
    )
    assert ran.returncode == 0, ran.stderr
    found = set(ran.stdout.split())
    assert {"PIL", "zlib"} <= found
    assert not found & heavy
