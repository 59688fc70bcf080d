"""Numerical part of rendering: camera, visibility, colours and symbols."""
