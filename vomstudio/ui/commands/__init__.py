"""Commands of menus, tool rail and search."""
