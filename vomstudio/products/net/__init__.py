"""The stereonet as a figure."""
