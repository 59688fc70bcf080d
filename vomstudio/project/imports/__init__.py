"""Imports into projects: readings, features from tables, and sidecars of other programs."""
