"""Checks for misread coordinates: other readings that fit far better."""
