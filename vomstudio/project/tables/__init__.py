"""Projections of the figures of features: the columns of CSV files, layers, and their rows."""
