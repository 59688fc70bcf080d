"""One file per model format; each defines READER. Names with an underscore are shared helpers."""
