"""Borders of facets in their planes."""
