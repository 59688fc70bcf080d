"""Sections: intersections of models with planes or curtains, and projected features."""
