"""Roughness of a surface, and deviations from its plane."""
