"""Joint analysis of several traces of beds."""
