"""Photos that show the selected features."""
