"""Elevation models: heights of a surface over a plane of reference, as rasters."""
