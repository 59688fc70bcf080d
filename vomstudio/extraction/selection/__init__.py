"""Selection of faces or points by drawn shapes, growing, neighbours, values and colours."""
