"""What the program proposes: facets, and lines that follow a contact."""
