"""Proposals of sets of planes."""
