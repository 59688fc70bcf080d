"""Parts of a glTF file: its JSON, its buffers and typed views of them.

Every index, offset and length in such a file is untrusted and is checked against the available data
before it is used.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import hashlib
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.io.models.formats._budget import Budget
from vomstudio.io.models.formats._common import read_whole_file
from vomstudio.io.models.mtl import find_companion

MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
MAX_JSON_BYTES = 1 << 28
MAX_JSON_VALUES = 4_000_000
COMPONENT_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
COMPRESSION_EXTENSIONS = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}
SUPPORTED_EXTENSIONS = (
    "KHR_materials_",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "EXT_texture_webp",
    "EXT_mesh_gpu_instancing",
)
POSITIONING_EXTENSIONS = ("CESIUM_RTC",)
"""Extensions of the whole file that change the position of the model."""


def companion_files(path: Path) -> list[Path]:
    """Return the existing buffer and image files to which a .gltf or .glb file refers.

    Raises InputError if it is not a glTF file.
    """
    document = Document(path, SilentProgress())
    paths: list[Path] = []
    for kind in ("buffers", "images"):
        for index in range(document.count(kind)):
            uri = document.item(kind, index).get("uri")
            if isinstance(uri, str) and not uri.startswith("data:"):
                with contextlib.suppress(InputError):
                    source = document.uri_bytes(uri, f"{kind}[{index}]")
                    assert isinstance(source, Path)
                    paths.append(source)
    return paths


class Document:
    """Content of a .gltf or .glb file.

    `content_hash` is the hash of the file and its buffer files, or empty for a document without
    buffer files.
    """

    def __init__(self, path: Path, progress: Progress) -> None:
        self.path = path
        self.progress = progress
        data = read_whole_file(path, progress)
        self.budget = Budget(path, len(data))
        self._binary: AnyArray | None = None
        is_packed = data[:4].tobytes() == MAGIC
        text = self._split_chunks(data) if is_packed else data.tobytes()
        self.json = self._parse_json(text)
        self._buffers: dict[int, AnyArray] = {}
        self._hasher = hashlib.sha256(data.data)
        self._has_files = False
        self._check_version()

    @property
    def content_hash(self) -> str:
        return self._hasher.hexdigest() if self._has_files else ""

    def error(self, reason: str, field: str | None = None) -> InputError:
        return InputError(
            Finding("file.damaged", reason=reason, format="glTF"), file=self.path, field=field
        )

    def _split_chunks(self, data: AnyArray) -> bytes:
        if len(data) < 20:
            raise self.error(tr("the file ends within its header"))
        version, length = struct.unpack_from("<II", data.data, 4)
        if version != 2:
            raise self.error(
                tr("this is glTF version {version}; this program reads version 2", version=version)
            )
        if length > len(data):
            raise InputError(
                Finding("file.truncated", size=len(data), expected=length), file=self.path
            )
        offset, text = 12, b""
        while offset + 8 <= length:
            size, kind = struct.unpack_from("<II", data.data, offset)
            offset += 8
            if size > length - offset:
                raise self.error(
                    tr("a chunk extends beyond the end of the file"), tr("byte {at}", at=offset - 8)
                )
            if kind == JSON_CHUNK and not text:
                text = data[offset : offset + size].tobytes()
            elif kind == BINARY_CHUNK and self._binary is None:
                self._binary = data[offset : offset + size]
            offset += size
        return text

    def _parse_json(self, text: bytes) -> dict[str, Any]:
        if len(text) > MAX_JSON_BYTES or sum(map(text.count, (b",", b"{", b"["))) > MAX_JSON_VALUES:
            raise self.error(tr("the JSON part is too large"))
        try:
            content = json.loads(text.decode("utf-8-sig"))
        except UnicodeDecodeError:
            raise self.error(tr("the JSON part is not in UTF-8")) from None
        except (ValueError, RecursionError) as error:
            reason = str(error).split(": line")[0][:80]
            raise InputError(
                Finding("file.damaged", reason=reason, format="glTF"),
                file=self.path,
                line=getattr(error, "lineno", None),
            ) from None
        if not isinstance(content, dict):
            raise self.error(tr("the JSON part contains no scene"))
        return content

    def _check_version(self) -> None:
        version = self.section("asset").get("version")
        if not isinstance(version, str) or not version.startswith("2"):
            raise self.error(tr("the glTF version is missing or is not 2"), "asset.version")
        required_extensions = self.json.get("extensionsRequired")
        for name in required_extensions if isinstance(required_extensions, list) else ():
            if name in COMPRESSION_EXTENSIONS:
                raise InputError(
                    Finding("model.unsupported", feature=COMPRESSION_EXTENSIONS[name]),
                    file=self.path,
                    field="extensionsRequired",
                )

    def unknown_extensions(self) -> list[str]:
        """Return the required extensions that are not supported."""
        required_extensions = self.json.get("extensionsRequired")
        names = (
            [n for n in required_extensions if isinstance(n, str)]
            if isinstance(required_extensions, list)
            else []
        )
        return [name for name in names if not name.startswith(SUPPORTED_EXTENSIONS)]

    def extensions_to_report(self) -> list[str]:
        """Return the unsupported extensions that are required or change the position."""
        unknown_names = self.unknown_extensions()
        positioning_names = [
            n
            for n in POSITIONING_EXTENSIONS
            if n in self.section("extensions") and n not in unknown_names
        ]
        return [*unknown_names, *positioning_names]

    def is_known_extension(self, extension: str) -> bool:
        """Return whether an extension is supported or has already been reported."""
        return extension.startswith(SUPPORTED_EXTENSIONS) or extension in self.unknown_extensions()

    def section(self, name: str, parent: dict[str, Any] | None = None) -> dict[str, Any]:
        """Return the object `name`, which is empty if it is missing or has another type."""
        value = (self.json if parent is None else parent).get(name)
        return value if isinstance(value, dict) else {}

    def count(self, kind: str) -> int:
        entries = self.json.get(kind)
        return len(entries) if isinstance(entries, list) else 0

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Return the entry `index` of the list `kind`. Raises InputError."""
        if isinstance(index, bool) or not isinstance(index, int):
            raise self.error(tr("'{index}' is not a valid index", index=index), kind)
        if not 0 <= index < self.count(kind):
            raise self.error(tr("entry {index} is missing", index=index), kind)
        entry = self.json[kind][index]
        if not isinstance(entry, dict):
            raise self.error(tr("the entry has the wrong type"), f"{kind}[{index}]")
        return entry

    def integer(self, parent: dict[str, Any], key: str, default_value: int, field: str) -> int:
        """Return a count or offset. Raises InputError if it is not a non-negative integer."""
        value = parent.get(key, default_value)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**62:
            raise self.error(tr("'{key}' is not a whole number", key=key), field)
        return value

    def uri_bytes(self, uri: object, field: str) -> bytes | Path:
        """Return the bytes of a data URI, or the path of the file to which a URI refers.

        Raises InputError if the data are damaged or the file is missing.
        """
        if not isinstance(uri, str):
            raise self.error(tr("'uri' is not a string"), field)
        if uri.startswith("data:"):
            header, _, body = uri.partition(",")
            try:
                if header.endswith(";base64"):
                    return base64.b64decode(unquote_to_bytes(body), validate=True)
                return unquote_to_bytes(body)
            except (binascii.Error, ValueError):
                raise self.error(tr("the embedded data are damaged"), field) from None
        name = unquote_to_bytes(uri).decode("utf-8", "replace")
        path, problem = find_companion(self.path.parent, name)
        if path is None:
            raise InputError(
                Finding("model.part-missing", reason=problem), file=self.path, field=field
            )
        return path

    def _buffer(self, index: object) -> AnyArray:
        buffer = self.item("buffers", index)
        assert isinstance(index, int)
        if index in self._buffers:
            return self._buffers[index]
        field = f"buffers[{index}]"
        if "uri" in buffer:
            source = self.uri_bytes(buffer["uri"], field)
            if isinstance(source, bytes):
                data: AnyArray = np.frombuffer(source, np.uint8)
            else:
                data = read_whole_file(source, self.progress)
                self.budget.add(len(data))
                self._hasher.update(data.data)
                self._has_files = True
        elif index == 0 and self._binary is not None:
            data = self._binary
        else:
            raise self.error(tr("the data are missing"), field)
        length = self.integer(buffer, "byteLength", len(data), field)
        if length > len(data):
            raise InputError(
                Finding("file.truncated", size=len(data), expected=length),
                file=self.path,
                field=field,
            )
        self._buffers[index] = data
        return data

    def view(self, index: object) -> tuple[AnyArray, int]:
        """Return the bytes and the stride (0 if not stated) of a buffer view.

        Raises InputError if they are compressed or extend beyond the buffer.
        """
        view = self.item("bufferViews", index)
        field = f"bufferViews[{index}]"
        is_compressed = any(
            name in self.section("extensions", view) for name in COMPRESSION_EXTENSIONS
        )
        buffer = self.item("buffers", view.get("buffer"))
        # Uncompressed data may exist as a fallback for compressed data.
        has_fallback = any(
            self.section(name, self.section("extensions", buffer)).get("fallback") is True
            for name in COMPRESSION_EXTENSIONS
        )
        if is_compressed and has_fallback and "uri" not in buffer:
            raise self.error(tr("the uncompressed fallback data are missing"), field)
        data = self._buffer(view.get("buffer"))
        start = self.integer(view, "byteOffset", 0, field)
        length = self.integer(view, "byteLength", 0, field)
        if start + length > len(data):
            raise self.error(tr("the buffer view extends beyond its buffer"), field)
        return data[start : start + length], self.integer(view, "byteStride", 0, field)

    def accessor(self, index: object, *widths: int) -> AnyArray:
        """Return values (n, width) as stored, with normalised values as floats.

        Raises InputError if they are not in the file or their width is not in `widths`.
        """
        accessor = self.item("accessors", index)
        field = f"accessors[{index}]"
        kind = accessor.get("componentType")
        width = WIDTHS.get(str(accessor.get("type")))
        if not isinstance(kind, int) or kind not in COMPONENT_TYPES or width is None:
            raise self.error(tr("the type is unknown"), field)
        if width not in widths:
            raise self.error(tr("{width} values per row are not valid here", width=width), field)
        dtype = np.dtype(COMPONENT_TYPES[kind])
        count = self.integer(accessor, "count", 0, field)
        sparse_accessor = accessor.get("sparse")
        if "bufferView" in accessor:
            values = self._typed_values(
                accessor, accessor["bufferView"], dtype, count, width, field
            )
        elif isinstance(sparse_accessor, dict):
            self.budget.take(count * width * dtype.itemsize, field)
            values = np.zeros((count, width), dtype)
        else:
            raise self.error(tr("the accessor has no data"), field)
        if isinstance(sparse_accessor, dict):
            values = self._apply_sparse(values, sparse_accessor, field)
        if accessor.get("normalized") is True and dtype.kind in "iu":
            maximum = np.float32(np.iinfo(dtype).max)
            return np.asarray(np.maximum(values.astype(np.float32) / maximum, np.float32(-1.0)))
        return values

    def _typed_values(
        self,
        owner: dict[str, Any],
        view: object,
        dtype: np.dtype[Any],
        count: int,
        width: int,
        field: str,
    ) -> AnyArray:
        data, stride = self.view(view)
        start = self.integer(owner, "byteOffset", 0, field)
        row = dtype.itemsize * width
        stride = stride or row
        if stride < row or (count and start + stride * (count - 1) + row > len(data)):
            raise self.error(tr("the accessor extends beyond its buffer view"), field)
        if count == 0:
            return np.empty((0, width), dtype)
        return np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))

    def _apply_sparse(
        self, values: AnyArray, sparse_accessor: dict[str, Any], field: str
    ) -> AnyArray:
        count = self.integer(sparse_accessor, "count", 0, f"{field}.sparse")
        indices, replacements = (
            self.section("indices", sparse_accessor),
            self.section("values", sparse_accessor),
        )
        kind = COMPONENT_TYPES.get(indices.get("componentType", 0), "")
        if "u" not in kind:
            raise self.error(tr("the indices have an unknown type"), f"{field}.sparse")
        rows = self._typed_values(
            indices, indices.get("bufferView"), np.dtype(kind), count, 1, field
        )[:, 0]
        new_values = self._typed_values(
            replacements,
            replacements.get("bufferView"),
            values.dtype,
            count,
            values.shape[1],
            field,
        )
        if len(rows) and int(rows.max()) >= len(values):
            raise self.error(
                tr("the sparse indices refer to rows that do not exist"), f"{field}.sparse"
            )
        values = values.copy()
        values[rows] = new_values
        return values


def numbers(document: Document, values: object, n: int, location: str) -> FloatArray:
    if isinstance(values, list) and len(values) == n:
        try:
            array = np.array(values, np.float64)
        except (TypeError, ValueError, OverflowError):
            array = np.full(n, np.nan)
        if array.shape == (n,) and np.isfinite(array).all():
            return array
    raise document.error(tr("{count} numbers are required here", count=n), location)
