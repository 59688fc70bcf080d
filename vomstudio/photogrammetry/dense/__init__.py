"""Depth maps of undistorted photos, and one cloud of them."""
