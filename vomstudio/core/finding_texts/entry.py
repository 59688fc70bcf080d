"""Type of the entries of the catalogue."""

from __future__ import annotations

from typing import Literal

Severity = Literal["info", "warning", "error"]
Entry = tuple[Severity, str] | tuple[Severity, str, str]
"""Severity and text, or severity and the texts for one and for several of ``{count}``."""
