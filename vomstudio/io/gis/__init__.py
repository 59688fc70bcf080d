"""Coordinate systems, and file formats of GIS and CAD."""
