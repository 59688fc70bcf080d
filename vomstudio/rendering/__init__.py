"""Rendering with VTK; only the subpackage `qt` uses both Qt and VTK."""
