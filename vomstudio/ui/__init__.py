"""Window of the program: main window, panels, dialogs, commands and widgets."""
