"""Intersections of rays with meshes and clouds."""
