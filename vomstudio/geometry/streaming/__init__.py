"""Clouds too large for memory, read node by node."""
