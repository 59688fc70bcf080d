"""Maps of fracture traces: from files to figures and a picture."""
