"""Geometry without geology: arrays, frames, fits and their errors, meshes and clouds."""
