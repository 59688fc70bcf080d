"""Material libraries: what is found, and what is never opened."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import pytest
from PIL import Image

from tests.messages import by_code
from vomstudio.core.findings import Finding
from vomstudio.geometry.mesh import Material
from vomstudio.io.models.mtl import check_image, find_companion, parse_map_statement, read_library


def library(folder: Path, text: str) -> tuple[dict[str, Material], list[Finding]]:
    path = folder / "lib.mtl"
    path.write_text(text)
    materials, findings = read_library(path, folder)
    return materials, findings


@pytest.mark.parametrize(
    ("value", "name"),
    [
        ("tex.jpg", "tex.jpg"),
        ("-s 1 1 1 tex.jpg", "tex.jpg"),
        ("-s 2 tex.jpg", "tex.jpg"),
        ("-o 0.5 0 0 -bm 0.2 -clamp on my tex.jpg", "my tex.jpg"),
        ("-mm 0 1 -blendu off -texres 1024 a b c.png", "a b c.png"),
        ('"quoted name.jpg"', "quoted name.jpg"),
        ("-unknown tex.jpg", "-unknown tex.jpg"),
    ],
)
def test_texture_options_are_not_part_of_the_name(value: str, name: str) -> None:
    assert parse_map_statement(value)[0] == name


@pytest.mark.parametrize(
    "name", ["TEX.JPG", "sub\\Tex.jpg", "./sub/tex.jpg", "SUB/tex.JPG", '"tex.jpg"']
)
def test_texture_names_tolerate_case_backslashes_and_quotes(tmp_path: Path, name: str) -> None:
    (tmp_path / "sub").mkdir()
    for place in (tmp_path, tmp_path / "sub"):
        Image.new("RGB", (2, 2)).save(place / "tex.jpg")
    materials, findings = library(tmp_path, f"newmtl a\nmap_kd {name}\n")
    assert materials["a"].texture is not None
    assert materials["a"].texture.name == "tex.jpg"
    assert findings == []


@pytest.mark.parametrize(
    "name",
    [
        "../secret.jpg",
        "sub/../../secret.jpg",
        "{outside}/secret.jpg",
        "..\\secret.jpg",
        "C:\\photos\\secret.jpg",
        "\\\\server\\share\\secret.jpg",
        "//server/share/secret.jpg",
    ],
)
def test_a_texture_outside_the_folder_is_never_opened(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    home.mkdir()
    Image.new("RGB", (2, 2)).save(tmp_path / "secret.jpg")
    opened: list[str] = []
    monkeypatch.setattr(Image, "open", lambda p, *a: opened.append(str(p)))
    materials, (finding,) = library(
        home, "newmtl a\nmap_Kd " + name.format(outside=tmp_path) + "\n"
    )
    assert materials["a"].texture is None
    assert finding.code == "texture.unusable"
    assert opened == []


def test_texture_beside_the_model_replaces_a_broken_path(
    tmp_path: Path,
) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "wall.jpg")
    materials, (finding,) = library(tmp_path, "newmtl a\nmap_Kd D:\\survey 3\\wall.jpg\n")
    assert materials["a"].texture == tmp_path / "wall.jpg"
    assert finding.code == "texture.substituted"


def test_file_that_is_not_an_image_is_reported_and_unused(tmp_path: Path) -> None:
    (tmp_path / "tex.jpg").write_text("no image at all")
    materials, findings = library(tmp_path, "newmtl a\nmap_Kd tex.jpg\nnewmtl b\nmap_Kd gone.png\n")
    assert materials["a"].texture is None
    assert {each.code for each in findings} == {"texture.unusable"}
    assert [each.values["material"] for each in findings] == ["a", "b"]


def png_header(width: int, height: int) -> bytes:
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + body + struct.pack(">I", zlib.crc32(body))


def test_excessive_image_dimensions_are_rejected_from_the_header(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    path.write_bytes(png_header(2**31 - 1, 2**31 - 1) + b"\0\0\0\0IDAT")
    assert "bomb.png" in str(check_image(path))
    path.write_bytes(
        png_header(40_000, 40_000) + struct.pack(">I", 1_000_000) + b"IDAT" + bytes(1_000_000)
    )
    assert "40000 x 40000" in str(check_image(path))


def test_the_large_textures_of_surveys_pass(tmp_path: Path) -> None:
    path = tmp_path / "large.png"
    path.write_bytes(
        png_header(16384, 16384) + struct.pack(">I", 6_000_000) + b"IDAT" + bytes(6_000_000)
    )
    assert check_image(path) is None


@pytest.mark.parametrize("name", ["", ".", "..", "a\0b", "/", "C:", "\\"])
def test_unusual_names_find_no_file(tmp_path: Path, name: str) -> None:
    found, reason = find_companion(tmp_path, name)
    assert found is None
    assert reason


def test_invalid_color_is_reported_and_others_are_kept(tmp_path: Path) -> None:
    materials, findings = library(tmp_path, "Kd 9 9 9\nnewmtl a\nKd red\nnewmtl b b\nKd 2 0.5 -1\n")
    assert materials["a"].diffuse is None
    assert materials["b b"].diffuse == (1.0, 0.5, 0.0)
    assert by_code(findings)["material.color-invalid"]["line"] == 3


def test_binary_material_library_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "lib.mtl"
    path.write_bytes(b"newmtl a\n\0\0")
    materials, findings = read_library(path, tmp_path)
    assert materials == {}
    assert [each.code for each in findings] == ["material.file-unusable"]


def picture(path: Path) -> None:
    Image.new("RGB", (2, 2)).save(path)


@pytest.mark.parametrize(
    ("material", "names", "used"),
    [
        ("textured_0", ["textured_0_ab12.jpg"], "textured_0_ab12.jpg"),
        ("Wall", ["wall.png", "other.png"], "wall.png"),
        ("t_1", ["t_1_a.jpg", "t_10_b.jpg"], "t_1_a.jpg"),
        ("t", ["t_a.jpg", "t_2_b.jpg"], "t_a.jpg"),
        ("t", ["t_a.jpg", "t_normal.jpg"], "t_a.jpg"),
        ("t", ["t_a.jpg", "t_b.jpg"], None),
        ("t", ["texture.jpg"], None),
        ("t", ["t_normal.jpg"], None),
        ("t", ["t_a.txt"], None),
    ],
)
def test_a_missing_texture_is_replaced_by_the_only_picture_of_that_name(
    tmp_path: Path, material: str, names: list[str], used: str | None
) -> None:
    for name in names:
        picture(tmp_path / name) if not name.endswith(".txt") else (tmp_path / name).touch()
    others = "".join(f"newmtl {name}\n" for name in ("t_10", "t_2"))
    (tmp_path / "lib.mtl").write_text(f"newmtl {material}\nmap_Kd not_found\n{others}")
    materials, findings = read_library(tmp_path / "lib.mtl", tmp_path)
    texture = materials[material].texture
    assert (None if texture is None else texture.name) == used
    (message,) = findings
    if used is not None:
        assert isinstance(message, Finding)
        assert message.code == "texture.by-name"
        assert message.values["picture"] == used
        assert message.values["missing"] == "not_found"


def test_existing_texture_is_never_replaced(tmp_path: Path) -> None:
    picture(tmp_path / "a_1.png")
    (tmp_path / "own.png").write_bytes(b"no picture")
    materials, _ = library(tmp_path, "newmtl a\nmap_Kd own.png\n")
    assert materials["a"].texture is None
