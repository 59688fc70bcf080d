"""The parts of the stereonet dock: what it shows, how it is drawn, chosen and written."""
