"""Depth maps of undistorted photos, and their fused cloud."""
