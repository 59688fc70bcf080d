"""Selections, computed fields and proposals on the surface of a model."""
