"""Identifiers of records."""

from __future__ import annotations

import secrets


def new_id(prefix: str) -> str:
    """Return a new identifier that is unique across all records and projects."""
    return f"{prefix}-{secrets.token_hex(6)}"
