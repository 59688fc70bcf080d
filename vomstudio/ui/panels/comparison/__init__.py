"""Comparison of two models of the same rock."""
