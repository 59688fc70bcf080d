"""Coordinate reference systems, and file formats of GIS and CAD programs."""
