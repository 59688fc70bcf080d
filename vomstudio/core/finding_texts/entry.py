"""Type of the catalogue entries."""

from __future__ import annotations

from typing import Literal

Severity = Literal["info", "warning", "error"]
Entry = tuple[Severity, str] | tuple[Severity, str, str]
"""Severity and text, or severity with the singular and plural texts for ``{count}``."""
