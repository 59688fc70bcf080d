"""Slip on faults: its kinematics, and displacements measured."""
