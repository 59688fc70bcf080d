"""Exports of projects: tables, GIS layers, drawings, and files for other programs."""
