"""Sections and elevation models."""
