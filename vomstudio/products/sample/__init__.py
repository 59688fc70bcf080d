"""Comparison of measurements on the sample outcrop with the true values."""
