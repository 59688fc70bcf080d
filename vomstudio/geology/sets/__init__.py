"""Sets of orientations and their discontinuities."""
