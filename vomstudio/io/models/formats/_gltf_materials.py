"""Materials of a glTF file and the locations of their images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.mesh import Material
from vomstudio.io.models import image_store
from vomstudio.io.models.formats._gltf_document import Document, numbers
from vomstudio.io.models.mtl import check_image, texture_finding

UNUSED_MAPS = ("normalTexture", "occlusionTexture", "emissiveTexture")


def color_map(document: Document, material: object) -> dict[str, Any]:
    """Return the textureInfo of a material's colour; empty if it has no texture."""
    if material == -1:
        return {}
    entry = document.item("materials", material)
    texture_info = document.section(
        "baseColorTexture", document.section("pbrMetallicRoughness", entry)
    )
    if texture_info:
        return texture_info
    extension = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    return document.section("diffuseTexture", extension)


def _texture_transform(document: Document, texture: dict[str, Any]) -> dict[str, Any]:
    return document.section("KHR_texture_transform", document.section("extensions", texture))


def uv_set(document: Document, texture: dict[str, Any]) -> int:
    uv_set_number = _texture_transform(document, texture).get(
        "texCoord", texture.get("texCoord", 0)
    )
    return uv_set_number if isinstance(uv_set_number, int) and 0 <= uv_set_number < 100 else 0


def transform_uv(document: Document, uv: FloatArray, texture: dict[str, Any]) -> AnyArray:
    """Return texture coordinates in mesh convention: lower-left origin, transform applied."""
    transform = _texture_transform(document, texture)
    if "scale" in transform:
        uv = uv * numbers(document, transform["scale"], 2, "KHR_texture_transform")
    if "rotation" in transform:
        (angle,) = numbers(document, [transform["rotation"]], 1, "KHR_texture_transform")
        c, s = np.cos(angle), np.sin(angle)
        uv = uv @ np.array([[c, -s], [s, c]])
    if "offset" in transform:
        uv = uv + numbers(document, transform["offset"], 2, "KHR_texture_transform")
    return np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1).astype(np.float32)


def read_materials(
    document: Document, used_indices: list[int], findings: list[Finding]
) -> tuple[Material, ...]:
    images: dict[object, tuple[Path | None, str | None]] = {}
    result = []
    has_unused_maps = False
    for index in used_indices:
        if index == -1:
            result.append(Material(""))
            continue
        entry = document.item("materials", index)
        name = str(entry.get("name") or f"material_{index}")
        has_unused_maps = has_unused_maps or any(key in entry for key in UNUSED_MAPS)
        info = color_map(document, index)
        texture: Path | None = None
        if info:
            source = _image_index(document, info)
            if source not in images:
                images[source] = _image(document, source, name)
            texture, problem = images[source]
            if problem:
                findings.append(texture_finding(name, texture, problem))
        result.append(Material(name, texture, _diffuse_color(document, entry)))
    if has_unused_maps:
        findings.append(Finding("texture.only-colors"))
    return tuple(result)


def _diffuse_color(document: Document, entry: dict[str, Any]) -> tuple[float, float, float] | None:
    metallic_roughness = document.section("pbrMetallicRoughness", entry)
    extension = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    factor = metallic_roughness.get("baseColorFactor", extension.get("diffuseFactor"))
    if factor is None:
        return None
    r, g, b, _ = linear_to_srgb(
        np.clip(numbers(document, factor, 4, "baseColorFactor"), 0.0, 1.0)
    ).tolist()
    return r, g, b


def linear_to_srgb(linear_colors: AnyArray) -> AnyArray:
    """Convert linear-light glTF factors to sRGB values (IEC 61966-2-1)."""
    is_linear = linear_colors <= 0.0031308
    return np.where(
        is_linear,
        12.92 * linear_colors,
        1.055 * np.maximum(linear_colors, 0.0) ** (1 / 2.4) - 0.055,
    )


def _image_index(document: Document, info: dict[str, Any]) -> object:
    texture = document.item("textures", info.get("index"))
    webp = document.section("EXT_texture_webp", document.section("extensions", texture))
    return webp.get("source", texture.get("source"))


def _image(document: Document, index: object, material: str) -> tuple[Path | None, str | None]:
    """Return the file of an image, or None, and the reason if it cannot be used."""
    if index is None:
        return None, tr("it has no image in a supported format")
    entry = document.item("images", index)
    field = f"images[{index}]"
    name = entry.get("name")
    label = name if isinstance(name, str) and name else material
    try:
        if "bufferView" in entry:
            packed_view = document.view(entry["bufferView"])[0]
            # Stored under its hash because many images may contain the same bytes.
            document.budget.take(len(packed_view), field)
            content = packed_view.tobytes()
        else:
            source = document.uri_bytes(entry.get("uri"), field)
            if isinstance(source, Path):
                reason = check_image(source)
                return (None, reason) if reason else (source, None)
            content = source
    except InputError as error:
        return None, error.message.rstrip(".")
    if image_store.image_suffix(content) == ".img":
        return None, tr("'{image}' is not a readable image", image=label)
    try:
        stored_image = image_store.store_image(content, Path(label).stem if "." in label else label)
    except OSError as error:
        return None, tr(
            "it cannot be written to {folder} ({reason})",
            folder=image_store.folder(),
            reason=error.strerror,
        )
    reason = check_image(stored_image)
    return (None, reason) if reason else (stored_image, None)
