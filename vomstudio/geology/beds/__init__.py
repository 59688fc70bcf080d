"""Beds: logs of true thicknesses, joint analysis of traces, and extended planes."""
