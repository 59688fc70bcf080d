"""Gives the documentation's site the same contents as Help: the links of the first page."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from vomstudio.ui.dialogs.help.help_pages import list_sections  # noqa: E402


def on_config(config: Any) -> Any:
    """Called by the generator once it has read its settings."""
    nav: list[Any] = []
    for heading, pages in list_sections(Path(config["docs_dir"])).items():
        entries = [{page.title: page.path.name} for page in pages]
        nav += [{heading: entries}] if heading else entries
    config["nav"] = nav
    return config
