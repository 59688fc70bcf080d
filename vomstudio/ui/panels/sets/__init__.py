"""Proposal of sets of planes."""
