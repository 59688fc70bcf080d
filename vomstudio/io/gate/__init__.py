"""Imported coordinates and tables: their frame, conversion to metres, and checks."""
