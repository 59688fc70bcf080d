"""Photos: metadata, pixels, masks and cameras."""
