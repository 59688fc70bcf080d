"""Input gate: the frame of coordinates, and whether it is metric."""
