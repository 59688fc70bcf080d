"""Logging, display and reporting of the program's own errors."""
