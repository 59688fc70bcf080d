"""Coverage of faces and repeatability of picks."""
