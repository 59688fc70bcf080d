"""Coordinate systems and the file formats of GIS and CAD."""
