"""Patches as surfaces, and planes carried on through a model."""

from __future__ import annotations

from vomstudio.ui.analyse.surfaces.commands import commands as commands
