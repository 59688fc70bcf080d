"""Marks of points in photos: contradictions, and labels or photos without counterparts."""
