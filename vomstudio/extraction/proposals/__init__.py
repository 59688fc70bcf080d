"""Automatically proposed traces."""
