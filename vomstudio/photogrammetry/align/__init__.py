"""Alignment of photos: features, matches, cameras and lenses."""
