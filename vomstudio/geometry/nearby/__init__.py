"""Sums over the neighbours of millions of positions."""
