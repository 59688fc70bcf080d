"""Camera, visibility, colours and symbols as numbers, without Qt and VTK windows."""
