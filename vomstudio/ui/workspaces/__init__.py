"""The workspaces of the window: which panels each shows, and how they are arranged and kept."""
