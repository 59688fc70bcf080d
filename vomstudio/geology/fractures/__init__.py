"""Maps of fracture traces: number, length, connectivity and spacing."""
