"""Sums over the points near millions of places."""
