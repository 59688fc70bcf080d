"""Header of a PLY file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.mtl import decode

MAGIC = (b"ply\n", b"ply\r", b"ply ")
MAX_HEADER_BYTES = 1 << 20

TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    name: str
    type: str  # numpy, without byte order
    count_type: str | None = None  # of a list's length


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    byte_order: str  # "<", ">" or "" for text
    elements: tuple[Element, ...]
    textures: tuple[str, ...]
    body_offset: int  # first byte after it


def read_header(top: bytes, path: Path) -> Header:
    """Read the header. Raises InputError with the invalid line."""
    if not top.startswith(MAGIC):
        raise InputError(Finding("file.other-format", format="PLY"), file=path, line=1)
    position = 0
    byte_order: str | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    textures: list[str] = []
    names: set[tuple[int, str]] = set()
    line_number = 0

    def header_error(reason: str) -> InputError:
        return InputError(
            Finding("file.damaged", reason=reason, format="PLY"), file=path, line=line_number
        )

    while True:
        ends = [end for end in (top.find(b"\n", position), top.find(b"\r", position)) if end >= 0]
        if not ends:
            raise header_error(tr("the PLY header has no 'end_header'"))
        end = min(ends)
        line = decode(top[position:end])
        position = end + (2 if top[end : end + 2] == b"\r\n" else 1)
        line_number += 1
        words = line.split()
        if not words or words[0] == "obj_info" or (line_number == 1 and words == ["ply"]):
            continue
        if words[0] == "end_header":
            break
        if words[0] == "comment":
            if len(words) > 2 and words[1].lower() == "texturefile":
                textures.append(line.split(None, 2)[2].strip())
        elif words[0] == "format":
            if len(words) < 2 or words[1] not in FORMATS:
                raise header_error(
                    tr("the PLY format '{format}' is unknown", format=" ".join(words[1:]))
                )
            byte_order = FORMATS[words[1]]
        elif words[0] == "element":
            if len(words) != 3 or not words[2].isdecimal() or len(words[2]) > 18:
                raise header_error(
                    tr(
                        "'{line}' does not specify the name and count of an element",
                        line=line.strip(),
                    )
                )
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            if not elements:
                raise header_error(tr("a property precedes the first element"))
            is_list = words[1:2] == ["list"]
            kinds = words[2:4] if is_list else words[1:2]
            if len(words) != (5 if is_list else 3) or any(kind not in TYPES for kind in kinds):
                raise header_error(
                    tr("'{line}' is not a property of a known type", line=line.strip())
                )
            if is_list:
                if TYPES[kinds[0]][0] == "f":
                    raise header_error(
                        tr(
                            "the count of a list has a non-integer type in '{line}'",
                            line=line.strip(),
                        )
                    )
                header_property = Property(words[4], TYPES[kinds[1]], TYPES[kinds[0]])
            else:
                header_property = Property(words[2], TYPES[kinds[0]])
            key = (len(elements), header_property.name)
            if key in names:
                raise header_error(
                    tr(
                        "an element has the property '{property}' twice",
                        property=header_property.name,
                    )
                )
            names.add(key)
            elements[-1][2].append(header_property)
        else:
            raise header_error(
                tr("the line '{line}' of the PLY header is not valid", line=line.strip()[:60])
            )
    if byte_order is None:
        raise InputError(
            Finding("file.damaged", format="PLY", reason=tr("its header states no format")),
            file=path,
        )
    return Header(
        byte_order,
        tuple(Element(n, c, tuple(p)) for n, c, p in elements),
        tuple(textures),
        position,
    )
