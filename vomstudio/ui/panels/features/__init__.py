"""Tree, table and properties of the features."""
