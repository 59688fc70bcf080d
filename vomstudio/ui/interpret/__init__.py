"""Panels of the tools, the tree, the table and the properties of features."""
