"""Placement of models in World: observations, and the resulting registration."""
