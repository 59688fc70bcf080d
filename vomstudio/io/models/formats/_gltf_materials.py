"""Materials of a glTF, and where their images are."""

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

MAPS_NOT_USED = ("normalTexture", "occlusionTexture", "emissiveTexture")


def color_map(document: Document, material: object) -> dict[str, Any]:
    """The textureInfo of a material's colour; empty where it has none."""
    if material == -1:
        return {}
    entry = document.item("materials", material)
    found = document.section("baseColorTexture", document.section("pbrMetallicRoughness", entry))
    if found:
        return found
    older = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    return document.section("diffuseTexture", older)


def _transform(document: Document, texture: dict[str, Any]) -> dict[str, Any]:
    return document.section("KHR_texture_transform", document.section("extensions", texture))


def uv_set(document: Document, texture: dict[str, Any]) -> int:
    wanted = _transform(document, texture).get("texCoord", texture.get("texCoord", 0))
    return wanted if isinstance(wanted, int) and 0 <= wanted < 100 else 0


def moved(document: Document, uv: FloatArray, texture: dict[str, Any]) -> AnyArray:
    """Texture coordinates as the mesh has them: origin at the lower left, nothing left to apply."""
    move = _transform(document, texture)
    if "scale" in move:
        uv = uv * numbers(document, move["scale"], 2, "KHR_texture_transform")
    if "rotation" in move:
        (angle,) = numbers(document, [move["rotation"]], 1, "KHR_texture_transform")
        c, s = np.cos(angle), np.sin(angle)
        uv = uv @ np.array([[c, -s], [s, c]])
    if "offset" in move:
        uv = uv + numbers(document, move["offset"], 2, "KHR_texture_transform")
    return np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1).astype(np.float32)


def materials_of(
    document: Document, used: list[int], messages: list[Finding]
) -> tuple[Material, ...]:
    images: dict[object, tuple[Path | None, str | None]] = {}
    result = []
    extra = False
    for index in used:
        if index == -1:
            result.append(Material(""))
            continue
        entry = document.item("materials", index)
        name = str(entry.get("name") or f"material_{index}")
        extra = extra or any(key in entry for key in MAPS_NOT_USED)
        info = color_map(document, index)
        texture: Path | None = None
        if info:
            source = _image_of(document, info)
            if source not in images:
                images[source] = _image(document, source, name)
            texture, problem = images[source]
            if problem:
                messages.append(texture_finding(name, texture, problem))
        result.append(Material(name, texture, _diffuse(document, entry)))
    if extra:
        messages.append(Finding("texture.only-colors"))
    return tuple(result)


def _diffuse(document: Document, entry: dict[str, Any]) -> tuple[float, float, float] | None:
    rough = document.section("pbrMetallicRoughness", entry)
    older = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    factor = rough.get("baseColorFactor", older.get("diffuseFactor"))
    if factor is None:
        return None
    r, g, b, _ = srgb(np.clip(numbers(document, factor, 4, "baseColorFactor"), 0.0, 1.0)).tolist()
    return r, g, b


def srgb(linear: AnyArray) -> AnyArray:
    """From the linear light of glTF's factors to the values that images and MTL files hold
    (IEC 61966-2-1)."""
    low = linear <= 0.0031308
    return np.where(low, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1 / 2.4) - 0.055)


def _image_of(document: Document, info: dict[str, Any]) -> object:
    texture = document.item("textures", info.get("index"))
    webp = document.section("EXT_texture_webp", document.section("extensions", texture))
    return webp.get("source", texture.get("source"))


def _image(document: Document, index: object, material: str) -> tuple[Path | None, str | None]:
    """The file of an image, or what is wrong with it."""
    if index is None:
        return None, tr("it has no image in a format that can be read")
    entry = document.item("images", index)
    where = f"images[{index}]"
    name = entry.get("name")
    label = name if isinstance(name, str) and name else material
    try:
        if "bufferView" in entry:
            packed = document.view(entry["bufferView"])[0]
            # Kept under its hash: many images may be of the same bytes.
            document.budget.take(len(packed), where)
            content = packed.tobytes()
        else:
            source = document.uri_bytes(entry.get("uri"), where)
            if isinstance(source, Path):
                wrong = check_image(source)
                return (None, wrong) if wrong else (source, None)
            content = source
    except InputError as error:
        return None, error.message.rstrip(".")
    if image_store.ending_of(content) == ".img":
        return None, tr("'{image}' is not an image that can be read", image=label)
    try:
        kept = image_store.keep(content, Path(label).stem if "." in label else label)
    except OSError as error:
        return None, tr(
            "it cannot be written to {folder} ({reason})",
            folder=image_store.folder(),
            reason=error.strerror,
        )
    wrong = check_image(kept)
    return (None, wrong) if wrong else (kept, None)
