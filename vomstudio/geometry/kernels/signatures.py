"""Signatures of kernels, and their arguments in the form of the machine code."""

from __future__ import annotations

import ctypes
import operator
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

_FULL_TYPE_NAMES = {
    "float64": "f8",
    "float32": "f4",
    "int64": "i8",
    "int32": "i4",
    "int16": "i2",
    "uint8": "u1",
    "uint32": "u4",
    "boolean": "b1",
}
_SCALAR_TYPES: dict[str, tuple[Any, str]] = {
    "f8": (ctypes.c_double, "double"),
    "f4": (ctypes.c_float, "float"),
    "i8": (ctypes.c_int64, "i64"),
    "b1": (ctypes.c_bool, "i8"),
}
"""Types of single numbers: for ctypes and for LLVM."""
RESULT_TYPES: dict[str, Any] = {"i8": ctypes.c_int64, "f8": ctypes.c_double, "b1": ctypes.c_bool}


@dataclass(frozen=True)
class _KernelParameter:
    """Parameter of a kernel; `dimensions` is 0 for a single number."""

    kind: str
    dtype: np.dtype[Any]
    dimensions: int
    is_contiguous: bool

    def to_flat_arguments(self, position: int, value: Any) -> tuple[Any, ...]:
        """Return the arguments of the machine code.

        Raises
        ------
        TypeError
            If the value does not have the type of the parameter.
        OverflowError
            If an integer does not fit into 64 bits.
        """
        if self.dimensions == 0:
            return (self._number(value),)
        is_valid = (
            isinstance(value, np.ndarray)
            and value.dtype == self.dtype
            and value.ndim == self.dimensions
            and (value.flags.carray if self.is_contiguous else value.flags.behaved)
        )
        if not is_valid:
            layout = "contiguous " if self.is_contiguous else ""
            raise TypeError(
                f"Argument {position} of a kernel must be a writable {layout}array of "
                f"{self.dtype} with"
                f" {self.dimensions} dimensions."
            )
        address = value.__array_interface__["data"][0]
        return (0, 0, value.size, self.dtype.itemsize, address, *value.shape, *value.strides)

    def _number(self, value: Any) -> Any:
        if self.kind != "i8":
            return bool(value) if self.kind == "b1" else float(value)
        integer = operator.index(value)
        if not -(2**63) <= integer < 2**63:
            raise OverflowError("A number is too large for a kernel.")
        return integer

    def c_types(self) -> list[Any]:
        if self.dimensions == 0:
            return [_SCALAR_TYPES[self.kind][0]]
        lengths = [ctypes.c_int64] * (2 * self.dimensions)
        return [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2, ctypes.c_void_p, *lengths]

    def llvm_types(self) -> list[str]:
        if self.dimensions == 0:
            return [_SCALAR_TYPES[self.kind][1]]
        return ["ptr", "ptr", "i64", "i64", "ptr", *["i64"] * (2 * self.dimensions)]


class Signature:
    """Signature of a kernel in numba's notation, with arrays and numbers.

    numba passes an array as two owners (not needed), number of items, bytes of an item, address,
    lengths and strides; addresses for results and errors precede all arguments.

    Raises
    ------
    ValueError
        If the signature contains other types.
    """

    def __init__(self, text: str) -> None:
        text = "".join(text.split())
        match = re.fullmatch(r"(Tuple\(\([\w,]+\)\)|\w+)\((.*)\)", text)
        if match is None:
            raise ValueError(f"'{text}' is not a signature of arrays and numbers.")
        result_type, argument_types = match.groups()
        self._has_single_result = not result_type.startswith("Tuple")
        names = (
            []
            if result_type == "void"
            else result_type.removeprefix("Tuple").strip("()").split(",")
        )
        kinds = {_FULL_TYPE_NAMES.get(name, name) for name in names}
        if len(kinds) > 1 or not kinds <= set(RESULT_TYPES):
            raise ValueError(f"'{text}' gives something else than numbers of one kind.")
        kind = kinds.pop() if kinds else None
        self._result_count = len(names)
        # The code always expects an address for the result, even if it returns nothing.
        self._result_array_type: Any = RESULT_TYPES.get(kind or "i8", ctypes.c_int64) * max(
            1, len(names)
        )
        self._parameters = [
            _parse_parameter(word) for word in re.findall(r"\w+(?:\[[^\]]*\])?", argument_types)
        ]

    def c_function(self) -> Any:
        """Return the ctypes type of the machine code's entry.

        It releases the GIL during a call.
        """
        types = [c_type for parameter in self._parameters for c_type in parameter.c_types()]
        return ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *types)

    def llvm_types(self) -> list[str]:
        """Return the LLVM types of the entry's arguments."""
        return [
            "ptr",
            "ptr",
            *(llvm_type for parameter in self._parameters for llvm_type in parameter.llvm_types()),
        ]

    def call(self, entry: Any, args: tuple[Any, ...]) -> tuple[bool, Any]:
        """Return whether the call succeeded, and the result.

        Raises
        ------
        TypeError
            If the number or the type of the arguments is wrong.
        OverflowError
            If an integer does not fit into 64 bits.
        """
        if len(args) != len(self._parameters):
            raise TypeError(f"A kernel takes {len(self._parameters)} arguments, not {len(args)}.")
        flat_arguments: list[Any] = []
        for position, (parameter, value) in enumerate(zip(self._parameters, args, strict=True)):
            flat_arguments += parameter.to_flat_arguments(position, value)
        results_buffer, error_pointer = self._result_array_type(), ctypes.c_void_p()
        if (
            entry(
                ctypes.addressof(results_buffer), ctypes.addressof(error_pointer), *flat_arguments
            )
            != 0
        ):
            return False, None
        results = tuple(results_buffer)[: self._result_count]
        return True, (
            results[0] if self._result_count else None
        ) if self._has_single_result else results


def _parse_parameter(word: str) -> _KernelParameter:
    name, _, layout = word.partition("[")
    kind = _FULL_TYPE_NAMES.get(name, name)
    if kind not in (_SCALAR_TYPES if not layout else _FULL_TYPE_NAMES.values()):
        raise ValueError(f"A kernel cannot take '{word}'.")
    axes = layout.rstrip("]").split(",") if layout else []
    return _KernelParameter(kind, np.dtype(kind), len(axes), layout.endswith("::1]"))
