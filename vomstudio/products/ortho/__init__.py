"""Orthophotos: scale-true pictures along a direction."""
