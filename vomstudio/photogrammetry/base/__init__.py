"""Foundations of all stages: COLMAP, memory limits, settings and stage folders."""
