"""Exports of projects: tables, GIS layers, drawings, files of other programs."""
