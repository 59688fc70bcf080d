"""Traces that the program proposes."""
