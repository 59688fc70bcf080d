"""Diagnostics of the alignment of a reconstruction."""
