"""What the program proposes."""
