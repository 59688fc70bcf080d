"""Photos: what their files say, their pixels, masks and cameras."""
