"""Identifiers of records."""

from __future__ import annotations

import secrets


def new_id(prefix: str) -> str:
    """Return an identifier that no other record of any project has."""
    return f"{prefix}-{secrets.token_hex(6)}"
