"""Services that all parts of the window use: studio, actions, theme, threads, texts."""
