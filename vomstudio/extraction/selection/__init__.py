"""Selection of faces or points: by a shape, by growing, by neighbours, by a value or a colour."""
