"""What was looked at, and how well it is picked again."""
