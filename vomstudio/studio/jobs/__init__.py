"""Typed jobs that run in worker processes, and their events, independent of Qt."""
