"""Planes, axes and models of the sample outcrop, compared with their true values."""
