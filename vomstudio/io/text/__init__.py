"""Text files as rows, tables and trees."""
