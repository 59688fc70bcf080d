"""Export of files in the formats of other programs, such as KML, GemPy and Stereonet."""
