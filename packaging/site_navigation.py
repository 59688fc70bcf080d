"""Gives the documentation's site the same contents as Help: the order of the first page's links."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from vomstudio.ui.shell.help_pages import pages_in  # noqa: E402


def on_config(config: Any) -> Any:
    """Called by the generator once it has read its settings."""
    pages = pages_in(Path(config["docs_dir"]))
    config["nav"] = [{page.title: page.path.name} for page in pages]
    return config
