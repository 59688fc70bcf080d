"""The stereonet: its source, settings, drawing and export."""
