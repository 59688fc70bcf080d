"""Control points and their marks in photos, in the formats of several programs."""
