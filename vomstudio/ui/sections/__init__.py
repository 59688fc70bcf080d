"""Docks in which the outcrop is cut, mapped and counted: sections, elevation models, fractures,
displacement."""
