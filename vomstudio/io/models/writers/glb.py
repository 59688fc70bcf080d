"""Writer of GLB files (glTF 2.0): Y up, float32 about an integer origin, embedded images."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.files.untrusted.pictures import open_picture
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.geometry.units import WORLD_AXES
from vomstudio.io.models.image_store import image_suffix
from vomstudio.io.models.offset_file import offset_path, offset_text
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import image_bytes, model_positions

# Within this distance, float32 resolves 0.02 mm, and a model may keep its origin.
MAX_COORDINATE_M = 256.0
MAX_ROUNDING_M = 3e-5
MAX_BYTES = 2**32 - 1
AXES = "glTF is +Y up (x = East, y = Up, z = -North); World = (x, -z, y)"
FLOAT, BYTE, UINT = 5126, 5121, 5125
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
ARRAY_BUFFER, INDEX_BUFFER = 34962, 34963


def write(request: WriteRequest) -> list[Finding]:
    """Write a GLB file with one primitive per material.

    The origin and the CRS are written to `asset.extras` and NAME.offset.txt; fields are `_NAME`
    attributes in float32. Raises TargetError if the model is too large for the format.
    """
    findings: list[Finding] = []
    origin = _origin(request.data)
    scene = _Scene(request, origin, findings)
    scene.build()
    chunks = scene.chunks(origin)
    text = offset_text(origin.tolist(), request.crs, _axes(request))
    paths = [request.path, offset_path(request.path)]
    size = len(chunks[0]) + sum(len(part) for part in scene.parts) + 28
    if size > MAX_BYTES:
        raise TargetError(
            Finding(
                "model.exceeds-format", format="GLB", size_gib=size / 2**30, alternatives="PLY, OBJ"
            ),
            file=request.path,
        )
    with atomic_group(paths, request.force, request.inputs) as (model, offset_sidecar):
        offset_sidecar.write_text(text, encoding="utf-8")
        with open(model, "wb") as file:
            request.progress.stage(tr("Writing the file"), len(scene.parts))
            body = sum(len(part) for part in scene.parts)
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(chunks[0]) + 8 + body))
            file.write(struct.pack("<I4s", len(chunks[0]), b"JSON") + chunks[0])
            file.write(struct.pack("<I4s", body, b"BIN\0"))
            for count, part in enumerate(scene.parts):
                file.write(part)
                request.progress.step(count + 1)
    return findings


def _axes(request: WriteRequest) -> str:
    if request.axes == WORLD_AXES:
        return AXES
    return f"glTF is +Y up; (x, -z, y) are {request.axes.description}"


def _origin(data: Mesh | PointCloud) -> FloatArray:
    bounds = data.bounds
    if np.abs(bounds).max() <= MAX_COORDINATE_M:
        return np.zeros(3)
    return np.asarray(np.rint(bounds.mean(axis=0)) + 0.0)


class _Scene:
    def __init__(self, request: WriteRequest, origin: FloatArray, findings: list[Finding]) -> None:
        self.request, self.origin, self.findings = request, origin, findings
        self.parts: list[bytes] = []
        self._offset = 0
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"VOM Studio {__version__}"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }
        self._images: dict[object, int] = {}
        self._error = 0.0

    def chunks(self, origin: FloatArray) -> list[bytes]:
        extras: dict[str, Any] = {
            "origin": [int(x) for x in origin],
            "axes": _axes(self.request) + " + origin",
        }
        if self.request.crs is not None:
            extras["crs"] = self.request.crs
        self.json["asset"]["extras"] = extras
        self.json["buffers"] = [{"byteLength": self._offset}]
        text = json.dumps(self.json, separators=(",", ":"), allow_nan=False).encode()
        return [text + b" " * (-len(text) % 4)]

    def build(self) -> None:
        data = self.request.data
        if isinstance(data, Mesh):
            self._add_mesh(data)
        else:
            normals = data.normals
            extra_attributes: dict[str, int] = {}
            if normals is not None:
                y_up_normals = np.stack([normals[:, 0], normals[:, 2], -normals[:, 1]], axis=1)
                extra_attributes["NORMAL"] = self._add_accessor(y_up_normals.astype("<f4"), FLOAT)
            self._add(self.request.path.stem, slice(None), extra_attributes, {"mode": 0})
        if self._error > MAX_ROUNDING_M:
            self.findings.append(Finding("model.positions-rounded", rounding_mm=self._error * 1000))
        for name, values in data.fields.items():
            if not _is_float32(values):
                self.findings.append(
                    Finding("model.field-rounded", field=name, precision="float32")
                )

    def _add_mesh(self, mesh: Mesh) -> None:
        materials = mesh.materials or (None,)
        offsets = mesh.material_offsets if mesh.materials else [0, len(mesh.faces)]
        is_untextured: AnyArray = np.zeros(len(mesh.faces), bool)
        if mesh.uv is not None:
            has_uv = np.asarray(np.isfinite(mesh.uv).all(axis=1))
            is_untextured = np.logical_not(has_uv[mesh.faces].all(axis=1))
        # Faces without texture coordinates form a separate part because (0, 0) would be a valid
        # position.
        parts = [
            (
                material,
                start + np.flatnonzero(is_untextured[start:stop] == has_no_texture),
                has_no_texture,
            )
            for material, start, stop in zip(materials, offsets[:-1], offsets[1:], strict=True)
            for has_no_texture in (False, True)
            if has_no_texture in is_untextured[start:stop] or (start == stop and not has_no_texture)
        ]
        for material, rows_of_part, has_no_texture in parts:
            faces = mesh.faces[rows_of_part]
            is_used = np.zeros(len(mesh.vertices), bool)
            is_used[faces] = True
            rows = np.flatnonzero(is_used)
            local_faces = (np.cumsum(is_used) - 1)[faces]
            extra_attributes: dict[str, int] = {}
            primitive: dict[str, Any] = {"mode": 4}
            if mesh.uv is not None and len(rows) and not has_no_texture:
                uv = mesh.uv[rows].astype(np.float64)
                uv = np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1)
                extra_attributes["TEXCOORD_0"] = self._add_accessor(uv.astype("<f4"), FLOAT)
            if material is not None:
                part_material = replace(material, texture=None) if has_no_texture else material
                primitive["material"] = self._add_material(part_material)
            if not len(faces):
                continue
            primitive["indices"] = self._add_accessor(
                local_faces.reshape(-1, 1).astype("<u4"), UINT, INDEX_BUFFER
            )
            name = self.request.path.stem if material is None else material.name or "untextured"
            self._add(name, rows, extra_attributes, primitive)
        n_loose_vertices = len(mesh.vertices) - len(np.unique(mesh.faces))
        if n_loose_vertices:
            self.findings.append(Finding("model.loose-points-left-out", count=n_loose_vertices))

    def _add(
        self, name: str, rows: Any, attributes: dict[str, int], primitive: dict[str, Any]
    ) -> None:
        data = self.request.data
        local_points = model_positions(data)[rows] - self.origin
        if float(np.abs(local_points).max(initial=0.0)) > float(np.finfo(np.float32).max):
            raise TargetError(
                Finding("model.exceeds-format", format="GLB", alternatives="PLY, OBJ"),
                file=self.request.path,
            )
        y_up_positions = np.stack(
            [local_points[:, 0], local_points[:, 2], -local_points[:, 1]], axis=1
        ).astype("<f4")
        deviation = np.abs(
            y_up_positions[:, [0, 2, 1]] * np.array([1, -1, 1], np.float32) - local_points
        )
        self._error = max(self._error, float(deviation.max(initial=0.0)))
        accessor = self._add_accessor(y_up_positions, FLOAT)
        self.json["accessors"][accessor]["min"] = y_up_positions.min(axis=0).astype(float).tolist()
        self.json["accessors"][accessor]["max"] = y_up_positions.max(axis=0).astype(float).tolist()
        attributes = {"POSITION": accessor, **attributes}
        if data.colors is not None:
            colors = np.full((len(y_up_positions), 4), 255, np.uint8)
            colors[:, :3] = data.colors[rows]
            attributes["COLOR_0"] = self._add_accessor(colors, BYTE)
            self.json["accessors"][-1]["normalized"] = True
        for field, values in data.fields.items():
            column = np.asarray(values)[rows].astype("<f4").reshape(-1, 1)
            attributes[f"_{field}"] = self._add_accessor(column, FLOAT)
        self.json["nodes"].append({"name": name, "mesh": len(self.json["meshes"])})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        self.json["meshes"].append(
            {"name": name, "primitives": [{"attributes": attributes, **primitive}]}
        )

    def _add_accessor(self, values: AnyArray, kind: int, target: int = ARRAY_BUFFER) -> int:
        view = self._add_view(np.ascontiguousarray(values).tobytes(), target)
        self.json["accessors"].append(
            {
                "bufferView": view,
                "componentType": kind,
                "count": len(values),
                "type": TYPES[values.shape[1]],
            }
        )
        return len(self.json["accessors"]) - 1

    def _add_view(self, content: bytes, target: int | None = None) -> int:
        view = {"buffer": 0, "byteOffset": self._offset, "byteLength": len(content)}
        if target is not None:
            view["target"] = target
        self.json["bufferViews"].append(view)
        self.parts.append(content + b"\0" * (-len(content) % 4))
        self._offset += len(self.parts[-1])
        self.request.progress.step(0)
        return len(self.json["bufferViews"]) - 1

    def _add_material(self, material: Material) -> int:
        metallic_roughness: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
        if material.diffuse is not None:
            metallic_roughness["baseColorFactor"] = [
                *srgb_to_linear(np.array(material.diffuse)).tolist(),
                1.0,
            ]
        if material.texture is not None:
            if material.texture not in self._images:
                self._images[material.texture] = self._add_image(material)
            metallic_roughness["baseColorTexture"] = {"index": self._images[material.texture]}
        entry = {
            "name": material.name,
            "pbrMetallicRoughness": metallic_roughness,
            "doubleSided": True,
        }
        self.json.setdefault("materials", []).append(entry)
        return len(self.json["materials"]) - 1

    def _add_image(self, material: Material) -> int:
        assert material.texture is not None
        content = image_bytes(material.texture)
        mime_type = {".jpg": "image/jpeg", ".png": "image/png"}.get(image_suffix(content))
        if mime_type is None:
            content, mime_type = _png_bytes(material.texture), "image/png"
        entry = {
            "name": material.texture.stem,
            "bufferView": self._add_view(content),
            "mimeType": mime_type,
        }
        self.json.setdefault("images", []).append(entry)
        self.json.setdefault("textures", []).append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1


def _png_bytes(path: Any) -> bytes:
    """Convert an image to PNG because glTF supports only JPEG and PNG.

    Raises TargetError if the image cannot be read.
    """
    stream = io.BytesIO()
    try:
        with open_picture(path) as image:
            mode = "RGBA" if "A" in image.getbands() else "RGB"
            image.convert(mode).save(stream, "PNG", compress_level=3)
    except (InputError, OSError, ValueError, SyntaxError) as error:
        raise TargetError(Finding("texture.unreadable", reason=error), file=path) from error
    return stream.getvalue()


def _is_float32(values: AnyArray) -> bool:
    float32_values = values.astype(np.float32)
    if values.dtype.kind == "f":
        return bool(np.array_equal(float32_values.astype(values.dtype), values, equal_nan=True))
    return bool((float32_values.astype(np.float64) == values.astype(np.float64)).all())


def srgb_to_linear(srgb: AnyArray) -> AnyArray:
    """Convert sRGB values to linear-light glTF factors (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


WRITER = Writer(to_translate("glTF scene"), (".glb",), write)
