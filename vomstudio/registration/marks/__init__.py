"""Marks of points in photos: which contradict each other, and which meet nothing."""
