"""Placement of models in the World frame by observations."""
