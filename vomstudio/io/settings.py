"""The user's settings: one typed TOML file in the configuration folder."""

from __future__ import annotations

import os
import threading
import tomllib
from collections.abc import Callable
from copy import deepcopy
from dataclasses import Field, asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.regular import read_small_text
from vomstudio.core.findings import Finding
from vomstudio.core.threads import start_thread

if TYPE_CHECKING:
    from vomstudio.geology.profiles import Thresholds

_RECENT = 10
_LARGEST = 1 << 20
"""Bytes of the file; no settings come near."""
_INSIDE: dict[str, tuple[type, ...]] = {
    "list[str]": (str,),
    "list[float]": (float, int),
    "dict[str, str]": (str,),
}
_CHOICES = {
    "notation": ("dipdir/dip", "strike/dip", "quadrant"),
    "projection": ("area", "angle"),
    "planes_as": ("discs", "symbols", "neither"),
    "theme": ("light", "dark", "system"),
}
"""What stands in a panel without a place for anything else."""


@dataclass
class Settings:
    """notation: how planes are written in the window (see geology.notation).
    contour: of the net, one of geology.density.DENSITY_METHODS, empty for none. contour_sigma: of
    Kamb's methods. contour_levels: those typed, empty for round ones. net_view: what the dock of
    the net shows: "net", or an angle of geology.roses. net_asked: what is drawn on it beside the
    sets. rose_bin, rose_by_length, rose_by_area: of the roses. figure_style: what the user has
    changed of printed figures (see products.net.figure_style).
    unclosed: projects that are open, or were when the program last ended without closing them.
    planes_as: "discs", "symbols" or "neither" in 3-D. hidden_columns: of the table, by title.
    window: geometry and panels as the window system keeps them, base64. limits: those of the
    verdict's thresholds that the user has changed, by their name, for projects without a profile of
    their own. profiles: the user's own, by name. point_budget: how many points of
    a streamed cloud are held at most; a COPC file with more is streamed. theme: "light", "dark" or
    "system". offer_tour: whether the start page offers the first tour."""

    notation: str = "dipdir/dip"
    projection: str = "area"
    contour: str = ""
    contour_filled: bool = True
    contour_each_set: bool = False
    contour_sigma: float = 3.0
    contour_levels: list[float] = field(default_factory=list)
    net_view: str = "net"
    net_asked: list[str] = field(default_factory=list)
    rose_bin: float = 10.0
    rose_by_length: bool = False
    rose_by_area: bool = True
    figure_style: dict[str, Any] = field(default_factory=dict)
    turntable: bool = True
    planes_as: str = "discs"
    hidden_columns: list[str] = field(default_factory=list)
    unclosed: list[str] = field(default_factory=list)
    recent: list[str] = field(default_factory=list)
    window: dict[str, str] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)
    profiles: dict[str, dict[str, Any]] = field(default_factory=dict)
    point_budget: int = 5_000_000
    theme: str = "system"
    offer_tour: bool = True

    @property
    def thresholds(self) -> Thresholds:
        from vomstudio.geology.profiles import Thresholds

        limits: dict[str, Any] = dict(self.limits)
        return Thresholds(**limits, profile="own limits" if limits else "error")

    def add_recent(self, path: Path) -> None:
        text = str(path)
        self.recent = [text, *(p for p in self.recent if p != text)][:_RECENT]

    def affecting_results(self) -> dict[str, Any]:
        """What is written beside every edit of the journal."""
        return {"thresholds": asdict(self.thresholds)}


def settings_path() -> Path:
    """`VOMSTUDIO_SETTINGS` names another file (tests, several set-ups side by side)."""
    if chosen := os.environ.get("VOMSTUDIO_SETTINGS"):
        return Path(chosen)
    from platformdirs import user_config_path

    return user_config_path("vomstudio", appauthor=False) / "settings.toml"


def read_settings(path: Path | None = None) -> tuple[Settings, list[Finding]]:
    """Return the settings, and a finding for each that is not valid and has its default."""
    path = path or settings_path()
    settings, problems = Settings(), []
    try:
        values = tomllib.loads(read_small_text(path, _LARGEST))
    except FileNotFoundError:
        return settings, []
    except (InputError, OSError, ValueError, RecursionError) as error:
        return settings, [
            Finding(
                "settings.unreadable",
                file=path,
                reason=error.message if isinstance(error, InputError) else error,
            )
        ]
    for known in fields(Settings):
        if known.name not in values:
            continue
        default, value = getattr(settings, known.name), values[known.name]
        try:
            if known.name == "limits":
                value = {key: float(v) for key, v in value.items()}
                Settings(limits=value).thresholds  # noqa: B018  unknown names are refused here
            elif known.name == "profiles":
                from vomstudio.geology.profiles import Thresholds

                for limits in value.values():
                    Thresholds(**limits)
            else:
                _check(known, value, default)
            setattr(settings, known.name, value)
        except (TypeError, ValueError, AttributeError) as error:
            problems.append(
                Finding("settings.invalid-value", file=path, setting=known.name, reason=error)
            )
    return settings, problems


def _check(known: Field[Any], value: Any, default: Any) -> None:
    """Raises TypeError or ValueError where a setting cannot have this value."""
    if type(value) is not type(default):
        raise TypeError(f"{type(default).__name__} expected")
    # The annotations of this module are text.
    inside = _INSIDE.get(str(known.type))
    parts = value.values() if isinstance(value, dict) else value
    if inside is not None and any(type(part) not in inside for part in parts):
        raise TypeError(f"{known.type} expected")
    if known.name in _CHOICES and value not in _CHOICES[known.name]:
        raise ValueError(f"one of {', '.join(_CHOICES[known.name])} expected")
    if known.name == "point_budget" and value < 1:
        raise ValueError("a number above 0 expected")


def write_settings(settings: Settings, path: Path | None = None) -> None:
    """Comments, the order of what is there, and settings that only other versions know stay.
    Raises TargetError."""
    path = path or settings_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TargetError(Finding("output.unwritable", reason=error.strerror), file=path) from error
    text = _toml(asdict(settings), _text_there(path))
    with atomic_write(path, force=True) as part:
        Path(part).write_text(text, encoding="utf-8")


def _text_there(path: Path) -> str:
    try:
        return read_small_text(path, _LARGEST)
    except (InputError, OSError, ValueError):
        return ""


class SettingsFile:
    """Writes the settings, in order, also beside whoever asks for it: the disk may take its time,
    which a window must not wait for."""

    def __init__(self, problem: Callable[[VomError], None]) -> None:
        """problem : receives the error, from any thread, if settings cannot be written"""
        self._problem = problem
        self._turn = threading.Lock()
        self._last = 0

    def write(self, settings: Settings) -> None:
        """Now. Raises TargetError."""
        self._last += 1
        with self._turn:
            write_settings(settings)

    def write_soon(self, settings: Settings) -> None:
        """As they are now, unless others come first."""
        self._last += 1
        # Not a daemon: the process ends only when they are kept.
        start_thread(
            self._write,
            self._last,
            deepcopy(settings),
            settings_path(),
            name="settings",
            daemon=False,
        )

    def _write(self, number: int, settings: Settings, path: Path) -> None:
        with self._turn:
            if number != self._last:
                return
            try:
                write_settings(settings, path)
            except VomError as error:
                self._problem(error)


def _toml(values: dict[str, Any], older: str) -> str:
    """A TOML document with these values, made of an older one where that can be read."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(older)
    except (TOMLKitError, RecursionError):
        return tomlkit.dumps(values)
    wanted = document.unwrap() | values
    _set(document, values)
    text = tomlkit.dumps(document)
    # Keys of tables that stand in several pieces or have dotted names can come out wrong.
    return text if tomllib.loads(text) == wanted else tomlkit.dumps(wanted)


def _set(table: Any, values: dict[str, Any]) -> None:
    """What is the same already keeps its form."""
    from tomlkit.items import AbstractTable

    for key, value in values.items():
        there = table.get(key)
        if isinstance(value, dict) and isinstance(there, AbstractTable):
            for gone in there.keys() - value.keys():
                del there[gone]
            _set(there, value)
        # True is 1 in Python and not in TOML.
        elif there != value or isinstance(there, bool) != isinstance(value, bool):
            table[key] = value
