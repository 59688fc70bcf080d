"""One module per format of ground control; each defines CONTROL_FORMAT."""
