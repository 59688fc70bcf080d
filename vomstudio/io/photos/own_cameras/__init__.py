"""Cameras of a model as written by other programs, with one module per program."""
