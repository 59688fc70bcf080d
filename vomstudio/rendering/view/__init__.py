"""Camera, visibility, colours and symbols as numbers: no Qt, no VTK window."""
