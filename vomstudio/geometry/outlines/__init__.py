"""Closed outlines on surfaces."""
