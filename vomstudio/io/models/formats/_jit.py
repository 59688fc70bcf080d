"""Compiled kernels that are kept between runs where the disk allows it."""

from vomstudio.geometry.kernels.jit import kernel, part, step

__all__ = ["kernel", "part", "step"]
