"""Maps of fracture traces: how many, how long, how connected, how far apart."""
