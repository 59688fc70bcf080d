"""Boundaries of facets in their planes."""
