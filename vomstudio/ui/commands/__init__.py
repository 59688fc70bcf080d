"""Commands of the menus, the tool rail and the search."""
