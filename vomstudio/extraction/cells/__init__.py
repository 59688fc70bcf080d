"""Planes of large clouds, found on cubic cells before single points are analysed."""
