"""Analysis of maps of fracture traces, with figures and a picture."""
