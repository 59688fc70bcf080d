"""Meshes and clouds: readers, writers, cache, copies."""
