"""Stereonets and rose diagrams as figures."""
