"""Values of a PLY file by element, from text or binary data of either byte order."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import (
    AnyArray,
    ByteArray,
    FloatArray,
    GenericArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.io.models.formats._budget import Budget
from vomstudio.io.models.formats._common import (
    Columns,
    missing_points_finding,
    refuse_decimal_commas,
)
from vomstudio.io.models.formats._ply_header import Element, Header

VALUES_PER_STEP = 1 << 20
BLOCK_BYTES = 1 << 22


@dataclass
class Table:
    """Values of one element: plain values by name, and lists as (lengths, all items)."""

    n: int
    scalars: dict[str, GenericArray] = field(default_factory=dict)
    lists: dict[str, tuple[IntArray, GenericArray]] = field(default_factory=dict)


def _report_missing(element: Element, count: int, findings: list[Finding]) -> None:
    """Append a finding that the file has fewer records than its header states."""
    if element.name == "vertex":
        findings.append(missing_points_finding(count, element.count))
        return
    findings.append(
        Finding("model.incomplete", count=count, promised=element.count, element=element.name)
    )


def read_binary(
    buffer: ByteArray,
    header: Header,
    budget: Budget,
    findings: list[Finding],
    progress: Progress,
) -> dict[str, Table]:
    tables: dict[str, Table] = {}
    offset = header.body_offset
    progress.stage(tr("Reading the model"), len(header.elements))
    for i, element in enumerate(header.elements):
        if element.properties and element.count:
            # The count is untrusted; each record takes at least this number of bytes.
            min_record_bytes = sum(
                np.dtype(property_.count_type or property_.type).itemsize
                for property_ in element.properties
            )
            n = min(element.count, (len(buffer) - offset) // min_record_bytes)
            table, offset = _binary_table(buffer, offset, element, n, header.byte_order, budget)
            if table.n < element.count:
                _report_missing(element, table.n, findings)
                offset = len(buffer)
        else:
            table = Table(0)
        tables.setdefault(element.name, table)
        progress.step(i + 1)
    return tables


def _binary_table(
    buffer: ByteArray,
    offset: int,
    element: Element,
    n: int,
    byte_order: str,
    budget: Budget,
) -> tuple[Table, int]:
    """Return up to n records starting at byte `offset`, and the position of the next byte."""
    list_properties = [property_ for property_ in element.properties if property_.count_type]
    list_lengths: dict[str, int] = {}
    if list_properties:
        list_lengths = _first_lengths(buffer, offset, element, byte_order) if n else {}
        if len(list_lengths) < len(list_properties):
            return _ragged_table(buffer, offset, element, n, byte_order, budget)
    dtype_fields: list[tuple[str, object]] = []
    for property_ in element.properties:
        if property_.count_type:
            dtype_fields.append((f"n {property_.name}", byte_order + property_.count_type))
            dtype_fields.append(
                (property_.name, (byte_order + property_.type, (list_lengths[property_.name],)))
            )
        else:
            dtype_fields.append((property_.name, byte_order + property_.type))
    record = np.dtype(dtype_fields)
    record_count = min(n, (len(buffer) - offset) // record.itemsize)
    array = np.frombuffer(buffer, record, record_count, offset)
    if any(
        np.any(array[f"n {list_property.name}"] != list_lengths[list_property.name])
        for list_property in list_properties
    ):
        return _ragged_table(buffer, offset, element, n, byte_order, budget)
    if list_properties and record_count < n:
        return _ragged_table(buffer, offset, element, n, byte_order, budget)
    if list_properties:
        budget.take(24 * record_count * len(list_properties), element.name)
    table = Table(record_count)
    for property_ in element.properties:
        values = array[property_.name].astype(property_.type)
        if property_.count_type:
            table.lists[property_.name] = (
                np.full(record_count, list_lengths[property_.name], np.int64),
                values.reshape(-1),
            )
        else:
            table.scalars[property_.name] = values
    return table, offset + record_count * record.itemsize


def _first_lengths(
    buffer: ByteArray, offset: int, element: Element, byte_order: str
) -> dict[str, int]:
    """Return the list lengths of the first record; incomplete if the record is invalid."""
    lengths: dict[str, int] = {}
    for property_ in element.properties:
        size = np.dtype(property_.type).itemsize
        if property_.count_type is None:
            offset += size
            continue
        kind = np.dtype(byte_order + property_.count_type)
        if offset + kind.itemsize > len(buffer):
            break
        n = int(np.frombuffer(buffer, kind, 1, offset)[0])
        offset += kind.itemsize + n * size
        if n < 0 or n > 64 or offset > len(buffer):
            break
        lengths[property_.name] = n
    return lengths


def _ragged_table(
    buffer: ByteArray,
    offset: int,
    element: Element,
    n: int,
    byte_order: str,
    budget: Budget,
) -> tuple[Table, int]:
    from vomstudio.io.models.formats import _ply_kernels as k

    data = buffer
    kinds = [np.dtype(property_.type) for property_ in element.properties]
    sizes = np.array([kind.itemsize for kind in kinds], np.int64)
    count_kinds = [
        np.dtype(property_.count_type) if property_.count_type else None
        for property_ in element.properties
    ]
    count_sizes = np.array(
        [count_kind.itemsize if count_kind else 0 for count_kind in count_kinds], np.int64
    )
    is_signed = np.array(
        [count_kind is not None and count_kind.kind == "i" for count_kind in count_kinds]
    )
    budget.take(24 * n * len(sizes), element.name)
    positions = np.empty((n, len(sizes)), np.int64)
    counts = np.empty((n, len(sizes)), np.int64)
    n = k.locate_values(
        data, offset, sizes, count_sizes, is_signed, byte_order == "<", positions, counts
    )
    positions, counts = positions[:n], counts[:n]
    table = Table(n)
    for j, property_ in enumerate(element.properties):
        out = np.empty(int(counts[:, j].sum()) * kinds[j].itemsize, np.uint8)
        k.gather(data, positions[:, j], counts[:, j], kinds[j].itemsize, out)
        values = out.view(byte_order + property_.type).astype(property_.type)
        if property_.count_type:
            table.lists[property_.name] = (counts[:, j].copy(), values)
        else:
            table.scalars[property_.name] = values
    if n:
        offset = int(positions[-1, -1] + counts[-1, -1] * sizes[-1])
    return table, offset


def read_text(
    buffer: bytearray,
    header: Header,
    path: Path,
    budget: Budget,
    findings: list[Finding],
    progress: Progress,
) -> dict[str, Table]:
    from vomstudio.io.models.formats import _ply_kernels as k

    if buffer.find(0, header.body_offset) >= 0:
        raise InputError(
            Finding(
                "file.damaged",
                format="PLY",
                reason=tr("its header specifies the text format, but its data are binary"),
            ),
            file=path,
        )
    if buffer.find(b"\n", header.body_offset) < 0:
        buffer[header.body_offset :] = buffer[header.body_offset :].replace(b"\r", b"\n")
    is_truncated = not buffer.endswith(b"\n")
    if is_truncated:
        buffer += b"\n"
    data = np.frombuffer(buffer, np.uint8)
    tables: dict[str, Table] = {}
    offset = header.body_offset
    n_invalid = 0
    first_invalid_offset: int | None = None
    finding_count = len(findings)
    progress.stage(tr("Reading the model"), len(buffer))
    for element in header.elements:
        if not element.count or not element.properties:
            tables.setdefault(element.name, Table(0))
            continue
        # A record takes at least two bytes for each of its values.
        record_count = min(
            element.count, (len(buffer) - offset) // (2 * len(element.properties)) + 1
        )
        budget.take((8 + 16 * len(element.properties)) * record_count, element.name)
        rows = _TextRows(element)
        starts = np.zeros(min(record_count, VALUES_PER_STEP) + 1, np.int64)
        longest_line = _longest_line(buffer, offset)
        capacity = max(VALUES_PER_STEP, longest_line)
        values = np.empty(capacity)
        unparsed = np.empty((capacity, 3), np.int64)
        while rows.n < record_count and offset < len(buffer):
            max_rows = min(record_count - rows.n, len(starts) - 1)
            offset, row, n = k.rows(data, offset, max_rows, starts, values, unparsed)
            ends = np.flatnonzero(unparsed[:, 0] < 0)
            for column, start, stop in unparsed[: ends[0] if len(ends) else capacity].tolist():
                value, is_number = _parse_value(bytes(buffer[start:stop]))
                values[column] = value
                if not is_number:
                    n_invalid += 1
                    first_invalid_offset = (
                        start if first_invalid_offset is None else first_invalid_offset
                    )
            budget.take(16 * n, element.name)
            rows.add(values[:n], starts[: row + 1])
            progress.step(offset)
        row = rows.n
        if row < element.count:
            if is_truncated and offset >= len(buffer) and row:
                row -= 1  # its last number may have lost digits
            _report_missing(element, row, findings)
            offset = len(buffer)
        tables.setdefault(element.name, rows.table(row, findings))
    if is_truncated and len(findings) == finding_count:
        findings.append(Finding("model.maybe-cut-short", end=tr("a line break")))
    if first_invalid_offset is not None:
        line = 1 + buffer.count(b"\n", 0, first_invalid_offset)
        refuse_decimal_commas(
            path, bytes(buffer[first_invalid_offset : first_invalid_offset + 60]).split()[0], line
        )
        findings.append(Finding("model.values-not-numbers", count=n_invalid, line=line))
    return tables


def _parse_value(token: bytes) -> tuple[float, bool]:
    from vomstudio.io.models.formats._decimals import python_number

    value = python_number(token)
    return (float("nan"), False) if value is None else (value, True)


def _longest_line(buffer: bytearray, offset: int) -> int:
    """Return an upper bound for the number of values in one line."""
    data = np.frombuffer(buffer, np.uint8)[offset:]
    longest_count, last_end = 0, -1
    for start in range(0, len(data), BLOCK_BYTES):
        ends = np.flatnonzero(data[start : start + BLOCK_BYTES] == 10) + start
        if len(ends):
            longest_count = max(
                longest_count, int(ends[0]) - last_end, int(np.diff(ends).max(initial=0))
            )
            last_end = int(ends[-1])
    return longest_count // 2 + 2


class _TextRows:
    """Rows of one element, converted to the types of their properties while they are read.

    Storing all numbers of a file as floats would take several times the size of the file.
    """

    def __init__(self, element: Element) -> None:
        self._properties = element.properties
        self._is_list = np.array(
            [property_.count_type is not None for property_ in element.properties]
        )
        self._columns = Columns(1)
        self._short_rows: list[IntArray] = []
        self.n = 0

    def add(self, values: FloatArray, starts: IntArray) -> None:
        """Append rows.

        `values` contains the values of the rows in sequence; `starts` (n + 1,) contains the index
        of the first value of each row.
        """
        from vomstudio.io.models.formats import _ply_kernels as k

        n, is_list = len(starts) - 1, self._is_list
        positions = np.empty((n, len(is_list)), np.int64)
        counts = np.empty((n, len(is_list)), np.int64)
        k.locate_row_values(values, starts, is_list, positions, counts)
        if not is_list.any():
            self._short_rows.append(self.n + np.flatnonzero(counts.min(axis=1, initial=1) == 0))
        for j, property_ in enumerate(self._properties):
            if property_.count_type:
                items = np.empty(int(counts[:, j].sum()))
                k.gather_values(values, positions[:, j], counts[:, j], items)
                is_integer = np.dtype(property_.type).kind in "iu"
                self._columns.add(f"n{j}", counts[:, j].astype(np.int32))
                self._columns.add(f"{j}", convert_indices(items) if is_integer else items)
            else:
                column = np.full(n, np.nan)
                has_value = counts[:, j] == 1
                column[has_value] = values[positions[has_value, j]]
                self._columns.add(f"{j}", _clip_to_type(column, property_.type))
        self.n += n

    def table(self, n: int, findings: list[Finding]) -> Table:
        """Return the first n rows as a table."""
        n_short = sum(int(np.count_nonzero(rows < n)) for rows in self._short_rows)
        if n_short:
            findings.append(Finding("model.short-lines", count=n_short))
        table = Table(n)
        for j, property_ in enumerate(self._properties):
            if property_.count_type:
                counts = self._take_column(f"n{j}", n, np.int64).astype(np.int64)
                items = self._take_column(f"{j}", int(counts.sum()), np.float64)
                table.lists[property_.name] = counts, items
            else:
                table.scalars[property_.name] = self._take_column(f"{j}", n, property_.type)
        return table

    def _take_column(self, name: str, n: int, dtype: npt.DTypeLike) -> GenericArray:
        column = self._columns.take(name, n)
        return np.empty(0, dtype) if column is None else column


def convert_indices(values: AnyArray) -> Int32Array:
    """Convert indices from text or floats to 32-bit integers.

    Values that are not numbers become -1, and values out of range the smallest or largest integer;
    none of these is a valid vertex.
    """
    limits = np.iinfo(np.int32)
    finite_values: FloatArray = np.nan_to_num(values, nan=-1.0)
    return np.clip(finite_values, limits.min, limits.max).astype(np.int32)


def _clip_to_type(values: FloatArray, type_: str) -> GenericArray:
    kind = np.dtype(type_)
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.nan_to_num(values), limits.min, limits.max).astype(kind)
