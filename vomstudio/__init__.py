"""VOM Studio: virtual outcrop models of geological structures."""

from vomstudio.version import __version__

__all__ = ["__version__"]
