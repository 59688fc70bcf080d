"""Alignment of one model to another by picked points and surfaces."""
