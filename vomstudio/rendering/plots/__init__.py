"""Data sets and pictures of PyVista, for scripts."""
