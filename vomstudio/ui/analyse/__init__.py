"""Stereonet, field readings, orthophotos."""
