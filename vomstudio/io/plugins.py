"""Discovery of format plugins: modules of a package, and entry points of other packages.

Each plugin is described by one object.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from types import ModuleType
from typing import Generic, TypeVar

from vomstudio.core.findings import Finding

T = TypeVar("T")


@dataclass(frozen=True)
class LoadedPlugins(Generic[T]):
    """Loaded plugins, and a finding for each one that could not be loaded."""

    all: tuple[T, ...]
    problems: tuple[Finding, ...]


def find_plugins(
    package: ModuleType, attribute: str, kind: type[T], group: str
) -> LoadedPlugins[T]:
    """Load the plugins of a package, then those of installed packages, sorted by name.

    Parameters
    ----------
    package : module
        Package whose modules are plugins, except those whose names begin with ``_``.
    attribute : str
        Name of the object in each module.
    kind : type
        Required class of the object.
    group : str
        Group of the entry points.

    Returns
    -------
    LoadedPlugins
        Loaded plugins. An object that cannot be loaded is reported in `problems` and does not
        affect the others.
    """
    from importlib.metadata import entry_points

    kind_name = kind.__name__
    plugins: list[T] = []
    broken_plugins: list[Finding] = []
    for module in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        if module.name.startswith("_"):
            continue
        name = f"{package.__name__}.{module.name}"
        candidate = getattr(importlib.import_module(name), attribute, None)
        if isinstance(candidate, kind):
            plugins.append(candidate)
        else:
            broken_plugins.append(Finding("plugin.not-defined", module=name, name=attribute))
    for point in sorted(entry_points(group=group), key=lambda entry_point: entry_point.name):
        plugin = f"{kind_name} '{point.name}' ({point.value})"
        try:
            candidate = point.load()
        except Exception as error:  # noqa: BLE001  errors of other packages must not stop the program
            broken_plugins.append(Finding("plugin.not-loaded", plugin=plugin, reason=error))
            continue
        if isinstance(candidate, kind):
            plugins.append(candidate)
        else:
            broken_plugins.append(Finding("plugin.other-kind", plugin=plugin, kind=kind_name))
    return LoadedPlugins(tuple(plugins), tuple(broken_plugins))
