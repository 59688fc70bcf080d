"""Planning of a photo survey."""
