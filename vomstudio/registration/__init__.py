"""From model coordinates to World: similarity transforms and what they leave over. No COLMAP."""
