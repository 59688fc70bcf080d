"""Elevation models: rasters of the height of a surface over a reference plane."""
