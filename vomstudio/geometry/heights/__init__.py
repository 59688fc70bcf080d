"""Structure of the heights of points over a plane."""
