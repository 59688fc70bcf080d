"""Window of the documentation."""
