"""Resumable stages of a reconstruction, and the data of its report."""
