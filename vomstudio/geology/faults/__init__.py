"""Kinematics and measured displacements of faults."""
