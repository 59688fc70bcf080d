"""Documentation window."""
