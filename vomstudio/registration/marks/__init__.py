"""Marks of points in photos: contradictory marks, and unknown labels or photos."""
