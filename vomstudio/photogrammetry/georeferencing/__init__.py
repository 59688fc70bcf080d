"""Registration of an aligned scene by GPS, control points and markers, and its lens errors."""
