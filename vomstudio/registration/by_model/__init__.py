"""One model registered by another."""
