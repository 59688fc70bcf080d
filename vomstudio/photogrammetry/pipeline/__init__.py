"""Resumable stages of a reconstruction, and their reports."""
