"""Choosing faces of a mesh or points of a cloud by hand: by a shape drawn over the picture, by
growing from a click, by their neighbours, by a value or a colour."""
