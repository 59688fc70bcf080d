"""Sets of orientations: how they are told apart."""
