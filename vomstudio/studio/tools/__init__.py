"""State machines that interpret gestures, without Qt or VTK."""
