"""Kinematic analysis of slopes."""
