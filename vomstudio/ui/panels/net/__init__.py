"""Stereonet: data source, settings, drawing and export."""
