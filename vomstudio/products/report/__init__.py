"""Printable reports and sheets."""
