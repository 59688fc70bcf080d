"""Analysis of fracture trace maps: number, length, connectivity and spacing."""
