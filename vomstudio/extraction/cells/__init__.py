"""Planes of large clouds, found on cubic cells before individual points are analysed."""
