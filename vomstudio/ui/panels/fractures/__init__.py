"""Analysis of fracture traces on a face."""
