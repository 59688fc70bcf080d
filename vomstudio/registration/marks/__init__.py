"""Checks of marks in photos: contradictory marks, unknown labels or photos."""
