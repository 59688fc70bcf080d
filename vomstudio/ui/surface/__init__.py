"""What the surface of the outcrop tells by itself: fields and facets."""
