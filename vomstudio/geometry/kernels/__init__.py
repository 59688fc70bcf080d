"""Compiled inner loops and the one place that compiles them."""
