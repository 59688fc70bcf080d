"""Files that other programs for structural geology read: their columns, their words."""
