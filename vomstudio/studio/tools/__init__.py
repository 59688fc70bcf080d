"""What a gesture means: state machines without Qt or VTK."""
