"""The stereonet: data source, settings, drawing and export."""
