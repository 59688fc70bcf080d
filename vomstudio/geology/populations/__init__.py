"""Sets of orientations as samples of a population: distributions, tests and weights."""
