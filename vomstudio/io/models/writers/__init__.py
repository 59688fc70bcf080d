"""Model writers, one module per format; see `vomstudio.io.models.writer`."""
