"""What given coordinates are mistaken for: readings of them that fit far better than as written."""
