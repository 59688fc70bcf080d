"""Registration of an aligned scene by GPS, control and markers, and its lens errors."""
