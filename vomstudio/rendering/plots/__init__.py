"""Data sets and plots of PyVista, for scripts."""
