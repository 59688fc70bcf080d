"""Conversion of the figures of features to columns of CSV files, layers and rows."""
