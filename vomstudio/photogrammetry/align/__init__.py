"""Features, matches, cameras and lenses: photos to an aligned scene."""
