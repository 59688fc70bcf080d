"""Cubic cells of a cloud's points, on which planes are found before single points are looked at."""
