"""Similarity transforms from model coordinates to World, and their residuals. No COLMAP."""
