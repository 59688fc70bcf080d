"""What the outcrop shows, and from where it is looked at."""
