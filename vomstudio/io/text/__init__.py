"""Text files as rows, tables and XML trees."""
