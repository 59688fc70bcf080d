"""The project folder: journal, layers, exports."""
