"""Coverage of a face by a grid of inspected cells."""
