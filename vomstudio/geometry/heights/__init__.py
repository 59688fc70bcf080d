"""What the heights of points over a plane tell beyond the plane."""
