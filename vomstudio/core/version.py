"""The version, at the bottom of the layers: everything may name it."""

__version__ = "0.1.0"
