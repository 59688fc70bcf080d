"""The main window: layout, workspaces, menus, status and start."""
