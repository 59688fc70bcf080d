"""Selection of faces or points by shapes, growing, neighbours, values and colours."""
