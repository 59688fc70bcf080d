"""Facets, traces that follow contacts, proposed lines and selections of a model."""
