"""PyVista data sets and plots for use in scripts."""
