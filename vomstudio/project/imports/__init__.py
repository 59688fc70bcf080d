"""Imports into projects: readings, features from tables, sidecars of other programs."""
