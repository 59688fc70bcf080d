"""Coverage of the face by a grid of inspected cells."""
