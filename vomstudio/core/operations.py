"""Operations of the program, declared once for every door."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Door = Literal["command", "function", "window", "project method", "project command"]
DOORS: tuple[Door, ...] = ("command", "function", "window", "project method", "project command")


@dataclass(frozen=True)
class Operation:
    """One operation with the doors that offer it.

    Parameters
    ----------
    name : str
        Name of the operation and of its command.
    options : tuple of type
        Options classes (`vomstudio.core.options`); the names of their fields are the parameters of
        the Python function and, without units, the options of the command.
    command_options : tuple of type
        Options classes of the command and the window only, such as files to write.
    function : str
        Name in ``vomstudio``; empty without one.
    command : str
        Name of the command, if it is not the name of the operation.
    window : str
        Module and class of the panel or dialog below ``vomstudio.ui``; empty without one.
    method : str
        Name of the method of ``vs.Project``; empty without one.
    action : str
        Action of ``vomstudio project``; empty without one.
    missing : dict
        Reason for each door that does not offer the operation.
    """

    name: str
    options: tuple[type[Any], ...] = ()
    command_options: tuple[type[Any], ...] = ()
    function: str = ""
    command: str = ""
    window: str = ""
    method: str = ""
    action: str = ""
    missing: Mapping[Door, str] = field(default_factory=dict)

    @property
    def command_name(self) -> str:
        """The command that offers the operation."""
        return self.command or self.name
