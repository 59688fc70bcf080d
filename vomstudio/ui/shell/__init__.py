"""Main window: layout, workspaces, menus, status line and start."""
