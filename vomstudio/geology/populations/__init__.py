"""Sets of orientations as samples of populations: distributions, tests and weights."""
