"""Shapes of folds by their poles, and the verdict on a view along their axis."""
