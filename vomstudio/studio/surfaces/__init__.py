"""What is chosen, worked out and proposed on the surface of a model."""
