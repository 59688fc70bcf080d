"""Reconstruction of models from photos; the only package that uses pycolmap."""

from vomstudio.photogrammetry.base.library_order import load_shared_libraries

# This call must precede the import of any module that uses pycolmap.
load_shared_libraries()
