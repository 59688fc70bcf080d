"""Basics of all stages: COLMAP as a library, memory, settings, folders of stages."""
