"""Sums over the points near places, of millions of places."""
