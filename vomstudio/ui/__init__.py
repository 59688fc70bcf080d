"""Qt: main window, actions, panels, item models, dialogs, job bridge."""
