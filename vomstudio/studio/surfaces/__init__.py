"""Selections, computed fields and proposals on the surfaces of models."""
