"""Statistics of orientations and the fold axis."""
