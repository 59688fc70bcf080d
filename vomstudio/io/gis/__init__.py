"""Coordinate reference systems, GeoTIFFs, and file formats of GIS and CAD programs."""
