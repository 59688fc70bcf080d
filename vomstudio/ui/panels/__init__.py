"""Panels of the inspector, the drawer and the docks."""
