"""Checks of imported coordinates: their frame, and whether it is metric."""
