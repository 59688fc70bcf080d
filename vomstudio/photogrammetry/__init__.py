"""Photos to model; the only user of pycolmap."""
