"""User settings: a typed TOML file in the configuration folder."""

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

_MAX_RECENT = 10
_MAX_BYTES = 1 << 20
"""Maximum size of the file."""
_ITEM_TYPES: dict[str, tuple[type, ...]] = {
    "list[str]": (str,),
    "list[float]": (float, int),
    "dict[str, str]": (str,),
}
_CHOICES = {
    "notation": ("dipdir/dip", "strike/dip", "quadrant"),
    "projection": ("area", "angle"),
    "planes_as": ("discs", "symbols", "neither"),
    "theme": ("light", "dark", "system"),
    "labels": ("auto", "all", "selected", "none"),
    "color_by": ("type", "set", "quality", "dip_direction"),
}
"""Settings with a fixed list of values."""
DETAIL_COLUMNS = (
    "95 % error",
    "Fit max",
    "Fit min",
    "± dip",
    "± dip dir.",
    "M",
    "K",
    "Coplan.",
    "Collin.",
    "n",
    "RMS",
    "Ext./res.",
    "Scale",
    "Bend",
    "Profile",
    "Rake",
    "Slip rake",
    "Nearest pick",
)
"""Columns of the table that are hidden until the user asks for them: the orientation
contains the error, and the inspector shows the other figures of the selected feature."""


@dataclass
class Settings:
    """User settings; the fields are the keys of the file.

    Parameters
    ----------
    notation : str
        Notation of planes in the window (`geology.notation`).
    projection : str
        Projection of the stereonet.
    contour : str
        Contouring method of the stereonet, one of `geology.density.DENSITY_METHODS`; empty for
        no contours.
    contour_sigma : float
        Sigma of the Kamb methods.
    contour_levels : list of float
        Contour levels entered by the user; empty for automatic ones.
    net_view : str
        View of the net panel: "net", or an angle of `geology.roses`.
    net_asked : list of str
        Elements drawn on the stereonet in addition to the sets.
    rose_bin, rose_by_length, rose_by_area
        Bin width in degrees, and weighting of rose diagrams.
    figure_style : dict
        Changes to the style of printed figures (`products.net.figure_style`).
    planes_as : str
        Display of planes in 3-D: "discs", "symbols" or "neither".
    hidden_columns : list of str
        Hidden columns of the table, by title; by default those of `DETAIL_COLUMNS`.
    unclosed : list of str
        Projects that are open, or were open when the program last ended.
    recent : list of str
        Recent projects, newest first.
    results_folder : str
        Folder of the result that was written last, or empty.
    window : dict
        Geometry and panels as stored by the window system, in base64.
    limits : dict
        Modified verdict thresholds by name, for projects without a profile.
    profiles : dict
        User-defined profiles by name.
    point_budget : int
        Maximum number of points of a streamed cloud in memory; larger COPC files are streamed.
    labels : str
        Features to label: "all", "selected", "none", or "auto" for all if there are only a few.
    color_by : str
        Property by which features are coloured: "type", "set", "quality" or "dip_direction".
    theme : str
        "light", "dark" or "system".
    offer_tour : bool
        Whether the start page offers the first tour.
    """

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
    hidden_columns: list[str] = field(default_factory=lambda: list(DETAIL_COLUMNS))
    unclosed: list[str] = field(default_factory=list)
    recent: list[str] = field(default_factory=list)
    results_folder: str = ""
    window: dict[str, str] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)
    profiles: dict[str, dict[str, Any]] = field(default_factory=dict)
    point_budget: int = 5_000_000
    theme: str = "system"
    labels: str = "auto"
    color_by: str = "type"
    offer_tour: bool = True

    @property
    def thresholds(self) -> Thresholds:
        """Verdict thresholds, including the changes made by the user."""
        from vomstudio.geology.profiles import Thresholds

        limits: dict[str, Any] = dict(self.limits)
        return Thresholds(**limits, profile="own limits" if limits else "error")

    def add_recent_project(self, path: Path) -> None:
        """Add a project to the list of recent projects."""
        text = str(path)
        self.recent = [text, *(path for path in self.recent if path != text)][:_MAX_RECENT]

    def recorded_settings(self) -> dict[str, Any]:
        """Return the settings that are recorded with every edit in the journal."""
        return {"thresholds": asdict(self.thresholds)}


def settings_path() -> Path:
    """Return the path of the settings file, which VOMSTUDIO_SETTINGS can override."""
    if override := os.environ.get("VOMSTUDIO_SETTINGS"):
        return Path(override)
    from platformdirs import user_config_path

    return user_config_path("vomstudio", appauthor=False) / "settings.toml"


def read_settings(path: Path | None = None) -> tuple[Settings, list[Finding]]:
    """Return the settings, and a finding for each invalid one, which gets its default."""
    path = path or settings_path()
    settings, problems = Settings(), []
    try:
        values = tomllib.loads(read_small_text(path, _MAX_BYTES))
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
    for setting in fields(Settings):
        if setting.name not in values:
            continue
        default_value, value = getattr(settings, setting.name), values[setting.name]
        try:
            if setting.name == "limits":
                value = {key: float(v) for key, v in value.items()}
                Settings(limits=value).thresholds  # noqa: B018  unknown names are refused here
            elif setting.name == "profiles":
                from vomstudio.geology.profiles import Thresholds

                for limits in value.values():
                    Thresholds(**limits)
            else:
                _check_setting(setting, value, default_value)
            setattr(settings, setting.name, value)
        except (TypeError, ValueError, AttributeError) as error:
            problems.append(
                Finding("settings.invalid-value", file=path, setting=setting.name, reason=error)
            )
    return settings, problems


def _check_setting(setting: Field[Any], value: Any, default: Any) -> None:
    """Raise TypeError or ValueError if a value is not valid for a setting."""
    if type(value) is not type(default):
        raise TypeError(f"{type(default).__name__} expected")
    # The annotations in this module are strings.
    item_types = _ITEM_TYPES.get(str(setting.type))
    items = value.values() if isinstance(value, dict) else value
    if item_types is not None and any(type(item) not in item_types for item in items):
        raise TypeError(f"{setting.type} expected")
    if setting.name in _CHOICES and value not in _CHOICES[setting.name]:
        raise ValueError(f"one of {', '.join(_CHOICES[setting.name])} expected")
    if setting.name == "point_budget" and value < 1:
        raise ValueError("a number above 0 expected")


def write_settings(
    settings: Settings, path: Path | None = None, base: Settings | None = None
) -> None:
    """Write the settings.

    Comments, the order of keys, and unknown settings of other versions are preserved. Raises
    TargetError.

    Parameters
    ----------
    settings : Settings
    path : Path, optional
        File; by default that of the user.
    base : Settings, optional
        Settings that this window last read or wrote. Values that another window has written
        since then remain, unless this window has changed them too.
    """
    path = path or settings_path()
    values = asdict(settings)
    if base is not None and path.is_file():
        values = _merge_settings(asdict(read_settings(path)[0]), asdict(base), values)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TargetError(Finding("output.unwritable", reason=error.strerror), file=path) from error
    text = _toml_text(values, _current_text(path))
    with atomic_write(path, force=True) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


def _merge_settings(
    stored_settings: dict[str, Any], base: dict[str, Any], current: dict[str, Any]
) -> dict[str, Any]:
    """Return the stored values with the changes of this window since `base`."""
    merged_settings = {
        key: stored_settings[key] if value == base[key] else value for key, value in current.items()
    }
    new_texts = [text for text in current["unclosed"] if text not in base["unclosed"]]
    removed_texts = {*new_texts, *base["unclosed"]} - set(current["unclosed"])
    unclosed_paths = [
        text for text in stored_settings["unclosed"] if text not in removed_texts.union(new_texts)
    ]
    merged_settings["unclosed"] = [*unclosed_paths, *new_texts]
    # Files opened since then precede the file that was the newest.
    recent_paths, former_recent = current["recent"], base["recent"][:1]
    opened_paths = (
        recent_paths[: recent_paths.index(former_recent[0])]
        if former_recent and former_recent[0] in recent_paths
        else recent_paths
    )
    merged_settings["recent"] = list(dict.fromkeys([*opened_paths, *stored_settings["recent"]]))[
        :_MAX_RECENT
    ]
    return merged_settings


def _current_text(path: Path) -> str:
    try:
        return read_small_text(path, _MAX_BYTES)
    except (InputError, OSError, ValueError):
        return ""


class SettingsFile:
    """Writer of the settings, which processes requests in order.

    `write_soon` writes in a thread so that a window does not wait for the disk.
    """

    def __init__(self, settings: Settings, report_problem: Callable[[VomError], None]) -> None:
        """Create the writer.

        Parameters
        ----------
        settings : Settings
            Settings as they were read.
        report_problem : callable
            Function that receives the error, in any thread, if settings cannot be written.
        """
        self._base, self._report_problem = deepcopy(settings), report_problem
        self._write_lock = threading.Lock()
        self._last_request = 0

    def write(self, settings: Settings) -> None:
        """Write the settings immediately. Raises TargetError."""
        self._last_request += 1
        with self._write_lock:
            self._write_merged(deepcopy(settings), settings_path())

    def write_soon(self, settings: Settings) -> None:
        """Write a copy of the settings in a thread, unless newer ones are written first."""
        self._last_request += 1
        # Not a daemon thread, so the process ends only after the settings are written.
        start_thread(
            self._write,
            self._last_request,
            deepcopy(settings),
            settings_path(),
            name="settings",
            daemon=False,
        )

    def _write(self, number: int, settings: Settings, path: Path) -> None:
        with self._write_lock:
            if number != self._last_request:
                return
            try:
                self._write_merged(settings, path)
            except VomError as error:
                self._report_problem(error)

    def _write_merged(self, settings: Settings, path: Path) -> None:
        write_settings(settings, path, self._base)
        self._base = settings


def _toml_text(values: dict[str, Any], previous_text: str) -> str:
    """Return a TOML document with the values, based on an older document if it is valid."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(previous_text)
    except (TOMLKitError, RecursionError):
        return tomlkit.dumps(values)
    expected_values_by_key = document.unwrap() | values
    _update_table(document, values)
    text = tomlkit.dumps(document)
    # tomlkit may write dotted keys, and tables in several parts, incorrectly.
    return (
        text
        if tomllib.loads(text) == expected_values_by_key
        else tomlkit.dumps(expected_values_by_key)
    )


def _update_table(table: Any, values: dict[str, Any]) -> None:
    """Set values of a table, keeping equal values in their current form."""
    from tomlkit.items import AbstractTable

    for key, value in values.items():
        current_value = table.get(key)
        if isinstance(value, dict) and isinstance(current_value, AbstractTable):
            for removed_key in current_value.keys() - value.keys():
                del current_value[removed_key]
            _update_table(current_value, value)
        # True equals 1 in Python but not in TOML.
        elif current_value != value or isinstance(current_value, bool) != isinstance(value, bool):
            table[key] = value
