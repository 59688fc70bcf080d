"""Analysis of a patch as a surface: its deviations from a plane."""
