"""Compiled inner loops (kernels) and their compilation."""
