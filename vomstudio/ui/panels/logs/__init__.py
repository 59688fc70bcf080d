"""Sedimentary logs along a line on the outcrop."""
