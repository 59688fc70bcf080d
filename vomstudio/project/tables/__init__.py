"""Projections of the figures of features: columns of CSV files, layers, and rows."""
