"""Widgets, words and helpers that every room of the window uses."""
