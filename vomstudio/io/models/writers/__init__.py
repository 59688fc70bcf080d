"""One module per format that can be written; see `vomstudio.io.models.writer`."""
