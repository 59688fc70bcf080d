"""Errors, findings, operations and threads that all other packages build on."""
