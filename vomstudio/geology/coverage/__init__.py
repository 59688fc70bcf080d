"""Coverage of outcrop faces, and repeatability of picks."""
