"""Operations of the program, declared once for all interfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Interface = Literal["command", "function", "window", "project method", "project command"]
INTERFACES: tuple[Interface, ...] = (
    "command",
    "function",
    "window",
    "project method",
    "project command",
)


@dataclass(frozen=True)
class Operation:
    """Operation and the interfaces that offer it.

    Parameters
    ----------
    name : str
        Name of the operation and of its command.
    options : tuple of type
        Options classes (`vomstudio.core.options`). The names of their fields are the parameters of
        the Python function and, without units, the options of the command.
    command_options : tuple of type
        Options classes that apply only to the command and the window, such as files to write.
    function : str
        Name of the function in ``vomstudio``; empty for an operation without a function.
    command : str
        Name of the command if it differs from the name of the operation.
    window : str
        Module and class of the panel or dialog below ``vomstudio.ui``; empty for an operation
        without either.
    method : str
        Name of the method of ``vs.Project``; empty for an operation without a method.
    action : str
        Action of ``vomstudio project``; empty for an operation without an action.
    missing : dict
        Reason for each interface that does not offer the operation.
    """

    name: str
    options: tuple[type[Any], ...] = ()
    command_options: tuple[type[Any], ...] = ()
    function: str = ""
    command: str = ""
    window: str = ""
    method: str = ""
    action: str = ""
    missing: Mapping[Interface, str] = field(default_factory=dict)

    @property
    def command_name(self) -> str:
        """Name of the command that offers the operation."""
        return self.command or self.name
