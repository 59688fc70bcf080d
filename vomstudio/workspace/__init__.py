"""The application without a screen: what the window, the command line and scripts share. No Qt."""
