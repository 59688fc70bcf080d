"""Handling of the program's own errors: logged, shown and reported."""
