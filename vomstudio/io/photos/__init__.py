"""Photos: names, metadata, pixels, masks and cameras."""
