"""The gate for everything that comes in: in which frame coordinates are, and is it metric."""
