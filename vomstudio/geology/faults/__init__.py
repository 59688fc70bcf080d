"""Kinematics of faults and measured displacements."""
