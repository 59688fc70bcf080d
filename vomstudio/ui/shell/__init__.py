"""The main window, its actions, files and status."""
