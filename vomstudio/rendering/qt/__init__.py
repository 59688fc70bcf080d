"""The viewport widget and what is painted over it: alone sees both Qt and VTK."""
