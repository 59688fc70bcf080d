"""Several traces of beds together."""
