"""Similarity transforms from model coordinates to World, with their residuals and errors."""
