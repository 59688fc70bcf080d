"""Reports and sheets to print."""
