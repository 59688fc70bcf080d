"""Reconstruction of models from photos; the only package that uses pycolmap."""

from vomstudio.photogrammetry.base.library_order import load_shared_libraries

# Before any module of this package can bring in pycolmap.
load_shared_libraries()
