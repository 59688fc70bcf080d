"""Recognition of file kinds by content, and rejection of kinds that a reader cannot use.

Extensions are not used: a GeoJSON file may be called ``stations.csv``. Only the beginning of a
file is examined, so the size of the file does not matter. The signatures come from the format
specifications and from the list of `file(1)`.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr

HEAD_BYTES = 1 << 16
"""Number of bytes examined at the beginning of a file."""

_MAX_XML_TAG = 2000
_ZIP_ENTRY = b"PK\x03\x04"


@dataclass(frozen=True)
class FileKind:
    """Kind of a file.

    Parameters
    ----------
    key : str
        Stable name for scripts.
    title : str
        Display name.
    remedy : str
        Action for the user if a text table is needed.
    """

    key: str
    title: str
    remedy: str


_ATTRIBUTES_REMEDY = to_translate(
    "Save its attributes as CSV, for example in QGIS, with coordinates in columns x, y and z."
)
_LINES_REMEDY = to_translate("Save its points as CSV with columns x, y and z.")
_SPREADSHEET_REMEDY = to_translate("Save the sheet as CSV.")
_MODEL_REMEDY = to_translate(
    "It is a model: open it as one, or convert it to points with 'convert'."
)
_CAMERAS_REMEDY = to_translate("Specify it with --model-cameras.")
_OTHER_CAMERAS_REMEDY = to_translate(
    "Export the cameras as COLMAP text, Agisoft XML or a table of photo, x, y and z."
)
_CONTROL_REMEDY = to_translate(
    "Write the points as gcp_list.txt (x y z pixel_x pixel_y photo, CRS in the first line)."
)
_PICTURE_REMEDY = to_translate("Specify the table that belongs to the picture.")
_DOCUMENT_REMEDY = to_translate("Copy its table into a text file (CSV).")
_ARCHIVE_REMEDY = to_translate("Unpack it and specify a file in it.")
_TABLE_REMEDY = to_translate("Export it as a CSV table.")

_KINDS = (
    FileKind("geojson", "GeoJSON", _ATTRIBUTES_REMEDY),
    FileKind("topojson", "TopoJSON", _ATTRIBUTES_REMEDY),
    FileKind("esri-json", "Esri JSON", _ATTRIBUTES_REMEDY),
    FileKind("cityjson", "CityJSON", _LINES_REMEDY),
    FileKind("opensfm-gcp", to_translate("OpenSfM ground control points (JSON)"), _CONTROL_REMEDY),
    FileKind("opensfm", to_translate("OpenSfM reconstruction (JSON)"), _CAMERAS_REMEDY),
    FileKind("openmvg", to_translate("OpenMVG cameras (sfm_data.json)"), _CAMERAS_REMEDY),
    FileKind(
        "alicevision", to_translate("AliceVision or Meshroom cameras (JSON)"), _CAMERAS_REMEDY
    ),
    FileKind("nerf", to_translate("NeRF cameras (transforms.json)"), _CAMERAS_REMEDY),
    FileKind("gltf-json", "glTF", _MODEL_REMEDY),
    FileKind("json", "JSON", _TABLE_REMEDY),
    FileKind("bundler", to_translate("Bundler cameras (bundle.out)"), _CAMERAS_REMEDY),
    FileKind("nvm", to_translate("VisualSFM cameras (NVM)"), _OTHER_CAMERAS_REMEDY),
    FileKind(
        "colmap",
        to_translate("COLMAP cameras or points (text)"),
        to_translate("Specify its folder with --model-cameras."),
    ),
    FileKind(
        "metashape-xml",
        to_translate("Metashape cameras or markers (XML)"),
        to_translate("Specify it with --model-cameras or --gcp."),
    ),
    FileKind("blocks-exchange", to_translate("iTwin Capture cameras (XML)"), _OTHER_CAMERAS_REMEDY),
    FileKind("kml", "KML", _ATTRIBUTES_REMEDY),
    FileKind("gpx", "GPX", _ATTRIBUTES_REMEDY),
    FileKind("gml", "GML", _ATTRIBUTES_REMEDY),
    FileKind("landxml", "LandXML", _LINES_REMEDY),
    FileKind("svg", to_translate("SVG drawing"), _LINES_REMEDY),
    FileKind("html", to_translate("web page (HTML)"), _DOCUMENT_REMEDY),
    FileKind("qgis", to_translate("QGIS project or style"), _ATTRIBUTES_REMEDY),
    FileKind("collada", "COLLADA", _MODEL_REMEDY),
    FileKind("vtk", to_translate("VTK data"), _MODEL_REMEDY),
    FileKind("xml", "XML", _TABLE_REMEDY),
    FileKind("dxf", to_translate("DXF drawing"), _LINES_REMEDY),
    FileKind("dwg", to_translate("DWG drawing"), _LINES_REMEDY),
    FileKind("geopackage", "GeoPackage", _ATTRIBUTES_REMEDY),
    FileKind("sqlite", to_translate("SQLite database"), _TABLE_REMEDY),
    FileKind("shapefile", "shapefile", _ATTRIBUTES_REMEDY),
    FileKind("dbase", to_translate("shapefile attribute table (dBASE)"), _SPREADSHEET_REMEDY),
    FileKind("mapinfo", "MapInfo MIF", _ATTRIBUTES_REMEDY),
    FileKind(
        "esri-grid",
        to_translate("height grid (Esri ASCII)"),
        to_translate(
            "Convert it to GeoTIFF, for example with gdal_translate, and open it as a model."
        ),
    ),
    FileKind(
        "surfer-grid",
        to_translate("height grid (Surfer)"),
        to_translate(
            "Convert it to GeoTIFF, for example with gdal_translate, and open it as a model."
        ),
    ),
    FileKind("gocad", "GOCAD", _LINES_REMEDY),
    FileKind("ply", "PLY", _MODEL_REMEDY),
    FileKind("obj", "Wavefront OBJ", _MODEL_REMEDY),
    FileKind("stl", "STL", _MODEL_REMEDY),
    FileKind("las", "LAS/LAZ", _MODEL_REMEDY),
    FileKind("e57", "E57", _MODEL_REMEDY),
    FileKind("glb", "glTF (GLB)", _MODEL_REMEDY),
    FileKind(
        "pcd",
        to_translate("PCL point cloud (PCD)"),
        to_translate("Convert it to PLY or LAS, for example in CloudCompare."),
    ),
    FileKind("xlsx", to_translate("Excel workbook"), _SPREADSHEET_REMEDY),
    FileKind("ods", to_translate("OpenDocument spreadsheet"), _SPREADSHEET_REMEDY),
    FileKind("docx", to_translate("text document"), _DOCUMENT_REMEDY),
    FileKind("kmz", "KMZ", _ATTRIBUTES_REMEDY),
    FileKind("office", to_translate("Excel or Word file (before 2007)"), _SPREADSHEET_REMEDY),
    FileKind("pdf", "PDF", _DOCUMENT_REMEDY),
    FileKind("rtf", "RTF", _DOCUMENT_REMEDY),
    FileKind("postscript", "PostScript", _DOCUMENT_REMEDY),
    FileKind("zip", to_translate("ZIP archive"), _ARCHIVE_REMEDY),
    FileKind("archive", to_translate("compressed archive"), _ARCHIVE_REMEDY),
    FileKind("parquet", "Parquet", _TABLE_REMEDY),
    FileKind("hdf5", "HDF5", _TABLE_REMEDY),
    FileKind("numpy", to_translate("NumPy array"), _TABLE_REMEDY),
    FileKind("tiff", "TIFF", _PICTURE_REMEDY),
    FileKind("jpeg", "JPEG", _PICTURE_REMEDY),
    FileKind("png", "PNG", _PICTURE_REMEDY),
    FileKind("picture", to_translate("picture"), _PICTURE_REMEDY),
)
_KINDS_BY_KEY = {kind.key: kind for kind in _KINDS}

_MAGIC = (
    (b"\0\0\x27\x0a", "shapefile"),
    (b"AutoCAD Binary DXF", "dxf"),
    (b"%PDF", "pdf"),
    (b"%!PS", "postscript"),
    (b"{\\rtf", "rtf"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "office"),
    (b"\x1f\x8b", "archive"),
    (b"7z\xbc\xaf\x27\x1c", "archive"),
    (b"Rar!\x1a\x07", "archive"),
    (b"\xfd7zXZ\0", "archive"),
    (b"\x28\xb5\x2f\xfd", "archive"),
    (b"\x89HDF\r\n\x1a\n", "hdf5"),
    (b"\x93NUMPY", "numpy"),
    (b"II*\0", "tiff"),
    (b"MM\0*", "tiff"),
    (b"II+\0", "tiff"),
    (b"MM\0+", "tiff"),
    (b"\xff\xd8\xff", "jpeg"),
    (b"\x89PNG\r\n\x1a\n", "png"),
    (b"\0\0\0\x0cjP  ", "picture"),
    (b"\xff\x4f\xff\x51", "picture"),
)
_BINARY_MAGIC = (
    (b"LASF", "las"),
    (b"ASTM-E57", "e57"),
    (b"glTF", "glb"),
    (b"PAR1", "parquet"),
    (b"GIF8", "picture"),
    (b"8BPS", "picture"),
    (b"DSBB", "surfer-grid"),
    (b"DSRB", "surfer-grid"),
    (b"BZh", "archive"),
    (b"AC10", "dwg"),
)
"""Signatures that consist of letters, as a table header may; zero bytes follow them."""
# The possessive quantifiers guarantee linear time for any file.
_TEXT_PATTERNS = (
    (re.compile(rb"(?:999[ \t\r]*+\n[^\n]*+\n[ \t]*+)*+0[ \t\r]*+\n\s*+SECTION\b"), "dxf"),
    (re.compile(rb"# Bundle file v"), "bundler"),
    (re.compile(rb"NVM_V\d"), "nvm"),
    (re.compile(rb"# (?:Image|Camera) list with |# 3D point list with "), "colmap"),
    (re.compile(rb"ply\s*\n(?:format|comment|obj_info)\b"), "ply"),
    (re.compile(rb"solid\b[^\n]*\n\s*facet\b"), "stl"),
    (re.compile(rb"(?:#[^\n]*+\n|\s)*+(?:mtllib\s|(?:v(?:[ \t]++[^\s,;]++){3,}+\s*+){3})"), "obj"),
    (re.compile(rb"# vtk DataFile"), "vtk"),
    (re.compile(rb"(?:#[^\n]*+\n)*+VERSION +0?\.\d+\s++FIELDS\b"), "pcd"),
    (re.compile(rb"ncols\s+\d+\s+nrows\s+\d+\s", re.IGNORECASE), "esri-grid"),
    (re.compile(rb"DSAA\s*\n"), "surfer-grid"),
    (re.compile(rb"GOCAD +[A-Z]\w+ +\d"), "gocad"),
    (re.compile(rb"Version +\d+\s++Charset\b", re.IGNORECASE), "mapinfo"),
)
_GEOJSON_TYPES = (
    rb"FeatureCollection|Feature|GeometryCollection|(?:Multi)?(?:Point|LineString|Polygon)"
)
_JSON_START = re.compile(rb'\x1e?\s*+(?:\{\s*+["}]|\[\s*+[\[{"])')
_JSON_MEMBERS: tuple[tuple[tuple[bytes, ...], str], ...] = (
    ((rb'"type"\s*+:\s*+"(?:' + _GEOJSON_TYPES + rb')"',), "geojson"),
    ((rb'"type"\s*+:\s*+"Topology"',), "topojson"),
    ((rb'"type"\s*+:\s*+"CityJSON',), "cityjson"),
    ((rb'"geometryType"\s*+:\s*+"esriGeometry',), "esri-json"),
    ((rb'"sfm_data_version"\s*+:',), "openmvg"),
    ((rb'"shot_id"\s*+:',), "opensfm-gcp"),
    ((rb'"shots"\s*+:', rb'"cameras"\s*+:'), "opensfm"),
    ((rb'"viewId"\s*+:', rb'"views"\s*+:'), "alicevision"),
    ((rb'"transform_matrix"\s*+:',), "nerf"),
    ((rb'"asset"\s*+:', rb'"(?:meshes|scenes|bufferViews)"\s*+:'), "gltf-json"),
)
"""Members that a JSON file of each kind contains; all of them are required."""
_XML_ROOT = re.compile(
    rb"(?s)(?P<prolog>(?:(?><\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>\[]*+(?:\[.*?\]\s*+)?>)\s*+)*+)"
    rb"<(?:[\w.-]++:)?(?P<root>[\w.-]++)(?P<attributes>[^>]*+)"
)
_XML_KINDS = {
    "kml": "kml",
    "gpx": "gpx",
    "featurecollection": "gml",
    "landxml": "landxml",
    "svg": "svg",
    "html": "html",
    "qgis": "qgis",
    "qlr": "qgis",
    "collada": "collada",
    "vtkfile": "vtk",
    "blocksexchange": "blocks-exchange",
}
_ZIP_KINDS = (
    (b"xl/", "xlsx"),
    (b"opendocument.spreadsheet", "ods"),
    (b"word/", "docx"),
    (b"opendocument.text", "docx"),
    (b"doc.kml", "kmz"),
)
_CONTROL_BYTES = bytes(b for b in range(32) if b not in b"\t\n\r\f\x1a") + b"\x7f"
_BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff")


def recognise_kind(head: bytes) -> FileKind | None:
    """Return the kind of a file from its first bytes, or None for tables and unknown kinds.

    Parameters
    ----------
    head : bytes
        Beginning of the file; `HEAD_BYTES` bytes are enough.
    """
    head = head[:HEAD_BYTES]
    key = _binary_key(head) or _text_key(_to_utf8(head))
    return None if key is None else _KINDS_BY_KEY[key]


def find_file_kind(path: str | Path) -> FileKind | None:
    """Return the kind of a regular file, or None if it is unknown or cannot be read."""
    try:
        with open_regular_file(path) as file:
            return recognise_kind(file.read(HEAD_BYTES))
    except (InputError, OSError):
        return None


def refuse_other_kind(path: str | Path, accepted_names: Collection[str] = ()) -> None:
    """Reject a file that is recognised as a kind other than a text table.

    Parameters
    ----------
    path : str or Path
    accepted_names : collection of str
        Keys of kinds that the caller can read.

    Raises
    ------
    InputError
        With the code ``file.other-kind`` and the values ``kind``, ``title`` and ``remedy``.
    """
    kind = find_file_kind(path)
    if kind is not None and kind.key not in accepted_names:
        raise other_kind_error(path, kind)


def other_kind_error(path: str | Path, kind: FileKind) -> InputError:
    """Return the error for a file whose kind cannot be used."""
    finding = Finding(
        "file.other-kind", kind=kind.key, title=tr(kind.title), remedy=tr(kind.remedy)
    )
    return InputError(finding, file=path)


def require_text(path: str | Path, data: bytes, accepted_names: Collection[str] = ()) -> None:
    """Reject content that is not text or is of a kind other than a text table.

    Parameters
    ----------
    path : str or Path
        Path of the file, for the error.
    data : bytes
        Complete content of the file.
    accepted_names : collection of str
        As for `refuse_other_kind`.

    Raises
    ------
    InputError
        As for `refuse_other_kind`; the kind of unknown content is ``binary``.
    """
    kind = recognise_kind(data)
    if kind is not None and kind.key not in accepted_names:
        raise other_kind_error(path, kind)
    if data[:2] in _BYTE_ORDER_MARKS or len(data.translate(None, _CONTROL_BYTES)) == len(data):
        return
    offset = next(i for i, byte in enumerate(data) if byte in _CONTROL_BYTES)
    raise other_kind_error(
        path,
        FileKind(
            "binary",
            tr("binary data (byte {place} is 0x{value:02x})", place=offset + 1, value=data[offset]),
            tr("Export it as text in UTF-8."),
        ),
    )


def _binary_key(head: bytes) -> str | None:
    if head.startswith(b"SQLite format 3\0"):
        # Application ID of OGC 12-128r18, and the IDs of earlier versions.
        return "geopackage" if head[68:72] in (b"GPKG", b"GP10", b"GP11") else "sqlite"
    if head.startswith(_ZIP_ENTRY):
        return next((key for name, key in _ZIP_KINDS if name in head), "zip")
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "picture"
    if head[:3] == b"\0\0\0" and head[4:8] == b"ftyp":
        return "picture"
    if head[:2] == b"BM" and len(head) > 14 and head[6:10] == b"\0\0\0\0":
        return "picture"
    if head[:1] in (b"\x03", b"\x30", b"\x83", b"\x8b", b"\xf5") and _is_dbase(head):
        return "dbase"
    magic = (*_MAGIC, *(_BINARY_MAGIC if b"\0" in head[:64] else ()))
    return next((key for start, key in magic if head.startswith(start)), None)


def _is_dbase(head: bytes) -> bool:
    """Return whether the header contains a date and its own length, as in dBASE files."""
    if len(head) < 33 or not (1 <= head[2] <= 12 and 1 <= head[3] <= 31):
        return False
    size = int.from_bytes(head[8:10], "little")
    return size > 32 and (size >= len(head) or head[size - 1] == 0x0D or head[size - 2] == 0x0D)


def _to_utf8(head: bytes) -> bytes:
    if head[:2] in _BYTE_ORDER_MARKS:
        return head[: len(head) & ~1].decode("utf-16", "ignore").encode("utf-8", "ignore")
    return head.removeprefix(b"\xef\xbb\xbf")


def _text_key(head: bytes) -> str | None:
    text = head.lstrip()
    if _JSON_START.match(text):
        members = (
            key for names, key in _JSON_MEMBERS if all(re.search(name, text) for name in names)
        )
        return next(members, "json")
    if text[:1] == b"<":
        return _xml_key(text)
    return next((key for pattern, key in _TEXT_PATTERNS if pattern.match(text)), None)


def _xml_key(text: bytes) -> str | None:
    match = _XML_ROOT.match(text)
    if match is None:
        return "xml" if text.startswith(b"<?xml") else None
    root = match["root"].decode("ascii", "replace").casefold()
    if root == "document" and re.search(rb"<chunk\b", text):
        return "metashape-xml"
    if root in _XML_KINDS:
        return _XML_KINDS[root]
    # A header such as "<x> <y> <z>" is not XML.
    is_xml = bool(match["prolog"].strip()) or b"xmlns" in match["attributes"][:_MAX_XML_TAG]
    return "xml" if is_xml else None
