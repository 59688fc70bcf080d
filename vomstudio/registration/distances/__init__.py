"""Distances of a model from another cloud or mesh."""
