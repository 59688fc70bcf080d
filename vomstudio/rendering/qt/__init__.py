"""Viewport widget and its overlays; the only package that uses both Qt and VTK."""
