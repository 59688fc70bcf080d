"""Formats are found, not listed: each is one module of a package of ours, or an entry point of a
package of somebody else's, and says what it can do in one object."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from types import ModuleType
from typing import Generic, TypeVar

from vomstudio.core.findings import Finding

T = TypeVar("T")


@dataclass(frozen=True)
class Found(Generic[T]):
    """All that were found, and why some could not be loaded, a sentence for each."""

    all: tuple[T, ...]
    broken: tuple[Finding, ...]


def find_plugins(package: ModuleType, attribute: str, kind: type[T], group: str) -> Found[T]:
    """Those of our own modules first, then those of installed packages, each in the order of their
    names.

    attribute : what a module of `package` calls its object; modules whose name begins with _ are
        parts of others
    kind : of which class the object must be; group : of the entry points that name one
    A package whose object cannot be loaded is named in `broken` and never stops the others.
    """
    from importlib.metadata import entry_points

    kind_name = kind.__name__
    found: list[T] = []
    broken: list[Finding] = []
    for module in sorted(pkgutil.iter_modules(package.__path__), key=lambda m: m.name):
        if module.name.startswith("_"):
            continue
        name = f"{package.__name__}.{module.name}"
        one = getattr(importlib.import_module(name), attribute, None)
        if isinstance(one, kind):
            found.append(one)
        else:
            broken.append(Finding("plugin.not-defined", module=name, name=attribute))
    for point in sorted(entry_points(group=group), key=lambda p: p.name):
        plugin = f"{kind_name} '{point.name}' ({point.value})"
        try:
            one = point.load()
        except Exception as error:  # noqa: BLE001  someone else's code must not stop ours
            broken.append(Finding("plugin.not-loaded", plugin=plugin, reason=error))
            continue
        if isinstance(one, kind):
            found.append(one)
        else:
            broken.append(Finding("plugin.other-kind", plugin=plugin, kind=kind_name))
    return Found(tuple(found), tuple(broken))
