"""Sections and logs: intersections of models with planes or curtains."""
