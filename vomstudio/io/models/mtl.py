"""Material libraries of OBJ files: names, colours and image paths.

No file outside the folder of the OBJ file is opened because the paths come from untrusted files.
The images are located and their headers are checked here; they are decoded elsewhere.
"""

from __future__ import annotations

import ntpath
import os
import posixpath
import re
from collections.abc import Iterable
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_regular_file, read_small_file
from vomstudio.core.files.untrusted.pictures import open_picture
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.mesh import Material
from vomstudio.io.text.encodings import convert_to_utf8, decode_text

MAX_LIBRARY_BYTES = 64 * 1024 * 1024
# 32768 x 32768 pixels take 3 GiB when decoded. Survey textures have up to 16384 x 16384 pixels.
MAX_IMAGE_PIXELS = 1 << 30

# Number of words that follow each option of a map statement (Wavefront's MTL specification).
_FIXED_OPTIONS = {
    "-blendu": 1,
    "-blendv": 1,
    "-bm": 1,
    "-boost": 1,
    "-cc": 1,
    "-clamp": 1,
    "-colorspace": 1,
    "-imfchan": 1,
    "-mm": 2,
    "-texres": 1,
    "-type": 1,
}
_VECTOR_OPTIONS = {"-o", "-s", "-t"}
_IMAGE_SUFFIXES = {".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp"}
_OTHER_MAP_NAME = re.compile(
    r"(?i)norm|nrm|rough|metal|occl|bump|disp|height|spec|gloss|alpha|opac|emis"
)
"""Pattern for the names of textures other than colour, such as normal or roughness maps."""


def decode(raw_bytes: bytes) -> str:
    """Decode text of unknown encoding as UTF-8 or else as Windows-1252."""
    try:
        return decode_text(raw_bytes)
    except UnicodeDecodeError:
        return raw_bytes.decode("cp1252", errors="replace")


def unquote(name: str) -> str:
    """Remove quotes around a name."""
    name = name.strip()
    if len(name) >= 2 and name[0] == name[-1] and name[0] in "\"'":
        return name[1:-1].strip()
    return name


def find_companion(folder: Path, name: str) -> tuple[Path | None, str | None]:
    """Find the file that `name` refers to in or below `folder`.

    Returns the path, or None, and the reason if the file is not found or was replaced by another.
    Backslashes separate folders. Case is ignored unless a file matches exactly. A path outside the
    folder is never opened: a file with the same name in the folder is used instead if it exists.
    """
    posix_name = unquote(name).replace("\\", "/")
    if not posix_name or "\0" in posix_name:
        return None, tr("'{file}' is not a file name", file=name)
    relative_path = posixpath.normpath(posix_name)
    drive = ntpath.splitdrive(posix_name)[0]
    if (
        drive
        or posixpath.isabs(relative_path)
        or relative_path == ".."
        or relative_path.startswith("../")
    ):
        file_name = posixpath.basename(relative_path)
        path = (
            _find_case_insensitive(folder, file_name) if file_name not in ("", ".", "..") else None
        )
        if path is None:
            return None, tr("'{file}' is outside the model's folder and was not opened", file=name)
        return (
            path,
            tr(
                "'{file}' is outside the model's folder, so '{found}' in this folder is used"
                " instead",
                file=name,
                found=path.name,
            ),
        )
    path = _find_case_insensitive(folder, relative_path)
    return (path, None) if path is not None else (None, tr("'{file}' was not found", file=name))


def _find_case_insensitive(folder: Path, relative_path: str) -> Path | None:
    try:
        exact_path = folder / relative_path
        if exact_path.is_file():
            return exact_path
        path = folder
        for part in relative_path.split("/"):
            names = {n.casefold(): n for n in sorted(os.listdir(path), reverse=True)}
            if part.casefold() not in names:
                return None
            path = path / names[part.casefold()]
        return path if path.is_file() else None
    except (OSError, ValueError):
        return None


def parse_map_statement(value: str) -> tuple[str, tuple[str, ...]]:
    """Return the file name in a map statement and the options before it."""
    remaining_text = value.strip()
    options: list[str] = []
    while remaining_text.startswith("-"):
        word, _, next_words = remaining_text.partition(" ")
        key = word.lower()
        if key in _FIXED_OPTIONS:
            n = _FIXED_OPTIONS[key]
            words = next_words.split(None, n)
            if len(words) <= n:
                break
            options.append(" ".join([key, *words[:n]]))
            remaining_text = words[n]
        elif key in _VECTOR_OPTIONS:
            number_texts: list[str] = []
            remaining_text = next_words.strip()
            while len(number_texts) < 3:
                first_word, _, following_numbers = remaining_text.partition(" ")
                if not following_numbers or not _is_number(first_word):
                    break
                number_texts.append(first_word)
                remaining_text = following_numbers.strip()
            options.append(" ".join([key, *number_texts]))
        else:
            break
    return unquote(remaining_text), tuple(options)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _is_shifting_image(option: str) -> bool:
    key, *number_texts = option.split()
    neutral_values = {"-s": 1.0, "-o": 0.0, "-t": 0.0}
    return key in neutral_values and any(
        float(number) != neutral_values[key] for number in number_texts
    )


def texture_finding(material: str | int, texture: Path | None, reason: str) -> Finding:
    """Return the finding about a texture that is not used or was replaced by another file."""
    code = "texture.unusable" if texture is None else "texture.substituted"
    return Finding(code, material=material, reason=reason)


def check_image(path: Path) -> str | None:
    """Read the header of an image, and return why it cannot be used, or None."""
    from PIL import UnidentifiedImageError

    try:
        with open_picture(path) as image:
            width, height = image.size
    except UnidentifiedImageError:
        return tr("'{image}' is not a readable image", image=path.name)
    except (InputError, OSError, ValueError, SyntaxError, MemoryError) as error:
        reason = error.message.rstrip(".") if isinstance(error, InputError) else error
        return tr("'{image}' cannot be read as an image ({reason})", image=path.name, reason=reason)
    if width < 1 or height < 1 or width * height > MAX_IMAGE_PIXELS:
        return tr(
            "'{image}' is too large ({width} x {height} pixels)",
            image=path.name,
            width=width,
            height=height,
        )
    return None


def read_library(path: Path, folder: Path) -> tuple[dict[str, Material], list[Finding]]:
    """Read the materials of an MTL file by name, and findings about the file.

    Images are searched for in the folder of the MTL file and then in `folder`, the folder of the
    OBJ file, but never outside `folder`.
    """
    findings: list[Finding] = []
    try:
        content = convert_to_utf8(read_small_file(path, MAX_LIBRARY_BYTES))
        if b"\0" in content:
            raise ValueError
    except (InputError, ValueError):
        return {}, [
            Finding(
                "material.file-unusable", reason=tr("'{file}' is not an MTL file", file=path.name)
            )
        ]
    except OSError as error:
        return {}, [
            Finding(
                "material.file-unusable",
                reason=tr(
                    "'{file}' cannot be read ({reason})", file=path.name, reason=error.strerror
                ),
            )
        ]
    textures: dict[str, str] = {}
    colors: dict[str, tuple[float, float, float]] = {}
    names: dict[str, None] = {}
    current_name: str | None = None
    text = decode(content).replace("\r\n", "\n").replace("\r", "\n").replace("\\\n", " ")
    for line_number, line in enumerate(text.split("\n"), 1):
        word, _, value = line.strip().replace("\t", " ").partition(" ")
        key = word.lower()
        value = value.strip()
        if key == "newmtl":
            current_name = unquote(value)
            names.setdefault(current_name)
        elif current_name is None:
            continue
        elif key == "kd":
            number_texts = value.split()
            if len(number_texts) == 1:
                number_texts *= 3
            try:
                r, g, b = (
                    min(max(float(line_number), 0.0), 1.0) for line_number in number_texts[:3]
                )
            except ValueError:
                findings.append(
                    Finding("material.color-invalid", file=path.name, line=line_number, color=value)
                )
                continue
            colors[current_name] = (r, g, b)
        elif key == "map_kd" and value:
            textures[current_name] = value
    images_by_statement: dict[str, tuple[Path | None, str | None, bool]] = {}
    materials: dict[str, Material] = {}
    for name in names:
        texture: Path | None = None
        if name in textures:
            value = textures[name]
            if value not in images_by_statement:
                images_by_statement[value] = _find_image(value, path.parent, folder)
            texture, problem, is_image_missing = images_by_statement[value]
            image_by_name = (
                _image_by_material_name(name, names, (path.parent, folder))
                if is_image_missing
                else None
            )
            if image_by_name is not None:
                texture = image_by_name
                findings.append(
                    Finding(
                        "texture.by-name",
                        file=path.name,
                        material=name,
                        missing=parse_map_statement(value)[0],
                        picture=image_by_name.name,
                    )
                )
            elif problem:
                findings.append(texture_finding(name, texture, problem))
            if texture is not None and any(map(_is_shifting_image, parse_map_statement(value)[1])):
                findings.append(Finding("texture.shift-unused", material=name, statement=value))
        materials[name] = Material(name, texture, colors.get(name))
    return materials, findings


def _find_image(
    value: str, library_folder: Path, folder: Path
) -> tuple[Path | None, str | None, bool]:
    """Return the image of a map statement, a warning about it, and whether it is missing.

    The image is None if it is missing or cannot be read; the warning is None if it is used as
    stated.
    """
    problem: str | None = None
    for name in dict.fromkeys((unquote(value), parse_map_statement(value)[0])):
        for search_folder in dict.fromkeys((library_folder, folder)):
            path, warning = find_companion(search_folder, name)
            if path is not None:
                error = check_image(path)
                return (None, error, False) if error else (path, warning, False)
            problem = warning
    return None, problem, True


def _image_by_material_name(
    material: str, materials: Iterable[str], folders: Iterable[Path]
) -> Path | None:
    """Return the only image whose name begins with the name of a material, or None.

    Polycam 3.4.5 writes ``map_Kd not_found`` next to ``NAME_ab12.jpg``. An image whose name begins
    with the longer name of another material belongs to that material.
    """
    longer_names = [name for name in materials if name != material and _has_prefix(name, material)]
    pictures: dict[str, Path] = {}
    for folder in folders:
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        for name in names:
            stem, suffix = posixpath.splitext(name)
            if (
                suffix.casefold() in _IMAGE_SUFFIXES
                and _has_prefix(stem, material)
                and not any(_has_prefix(stem, longer_name) for longer_name in longer_names)
                and not _OTHER_MAP_NAME.search(stem[len(material) :])
                and is_regular_file(folder / name)
            ):
                pictures.setdefault(name, folder / name)
    if len(pictures) != 1:
        return None
    picture = next(iter(pictures.values()))
    return None if check_image(picture) else picture


def _has_prefix(name: str, prefix: str) -> bool:
    """Return whether a name equals a prefix or continues it after a separator, ignoring case."""
    if not prefix or not name.casefold().startswith(prefix.casefold()):
        return False
    return not name[len(prefix) : len(prefix) + 1].isalnum()
