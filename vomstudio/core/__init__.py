"""Errors, findings, operations and threads, on which every other package is built."""
