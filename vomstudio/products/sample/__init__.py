"""Measurements on the sample outcrop compared with its truth."""
