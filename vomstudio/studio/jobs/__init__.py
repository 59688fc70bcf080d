"""Typed jobs that run in worker processes, and their events. No Qt."""
