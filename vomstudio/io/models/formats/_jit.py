"""Compiled kernels that are kept between runs where the disk allows it."""

from vomstudio.geometry.kernels.jit import kernel, part

__all__ = ["kernel", "part"]
