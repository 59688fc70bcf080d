"""Photos to model; the only user of pycolmap."""

from vomstudio.photogrammetry.base.library_order import load_shared_libraries

# Before any module of this package can bring in pycolmap.
load_shared_libraries()
