"""VOM Studio: virtual outcrop models of geological structures."""

__version__ = "0.1.0"
