"""An aligned scene on the ground: by GPS, control points, markers."""
