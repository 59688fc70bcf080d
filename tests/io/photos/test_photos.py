"""Photos and what their headers say, against EXIF written by hand and other readers."""

from __future__ import annotations

import os
import shutil
import time
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.io.photos import photo_maker as maker
from tests.messages import by_code, refused
from vomstudio.core.errors import InputError
from vomstudio.io.photos.camera_table import camera_models, find_camera, similar_cameras
from vomstudio.io.photos.photo import Photo
from vomstudio.io.photos.pixels import grey, read_mask, rotate_upright, thumbnail
from vomstudio.io.photos.reading import NoPhotosError, read_photos
from vomstudio.io.photos.xmp import read_drone_tags

CAMERA = {0x010F: maker.text("NIKON CORPORATION"), 0x0110: maker.text("NIKON D90")}


def one(folder: Path) -> Photo:
    (photo,) = read_photos(folder).photos
    return photo


# -- what EXIF says ------------------------------------------------------------------------------
def test_every_tag_of_a_camera_is_read(tmp_path: Path) -> None:
    maker.write_photo(
        tmp_path / "a.jpg",
        (160, 120),
        main={**CAMERA, 0x0112: maker.short(6)},
        exif={
            0x829A: maker.rational(1 / 250, 1_000_000),
            0x829D: maker.rational(8.0),
            0x8827: maker.short(200),
            0x9003: maker.text("2023:07:14 11:22:33"),
            0x9291: maker.text("25"),
            0x920A: maker.rational(35.0),
            0xA404: maker.rational(1.0),
            0xA405: maker.short(52),
            0xA431: maker.text("123 45\0\0"),
            0xA434: maker.text("35mm f/1.8"),
        },
        gps={**maker.at(-33.5, 18.25, 12.5), 0x1F: maker.rational(2.5)},
    )
    photo = one(tmp_path)
    assert (photo.name, photo.width, photo.height, photo.orientation) == ("a.jpg", 160, 120, 6)
    assert (photo.camera, photo.serial, photo.lens) == ("NIKON D90", "123 45", "35mm f/1.8")
    assert photo.taken_at == datetime(2023, 7, 14, 11, 22, 33, 250_000)
    assert (photo.focal_mm, photo.focal_35mm, photo.f_number, photo.iso) == (35, 52, 8, 200)
    assert photo.exposure_s == pytest.approx(1 / 250)
    assert photo.focal_px == pytest.approx(52 / 36 * 160)
    assert photo.sensor_width_mm == pytest.approx(35 / 52 * 36)
    assert "35 mm" in (photo.focal_source or "")
    assert photo.latitude_deg == pytest.approx(-33.5, abs=1e-9)
    assert photo.longitude_deg == pytest.approx(18.25, abs=1e-9)
    assert (photo.altitude_m, photo.altitude_reference) == (12.5, "sea level")
    assert (photo.gps_accuracy_m, photo.digital_zoom) == (2.5, 1.0)
    # f/8 at 1/250 s and ISO 200: log2(64 * 250) - 1.
    assert photo.exposure_value == pytest.approx(np.log2(64 * 250) - 1)


@pytest.mark.parametrize("ending", ["jpg", "png", "tif"])
def test_every_format_carries_its_exif(tmp_path: Path, ending: str) -> None:
    maker.write_photo(
        tmp_path / f"a.{ending}",
        main={0x010F: maker.text("Canon"), 0x0110: maker.text("Canon EOS 450D")},
        exif={0x920A: maker.rational(50.0)},
    )
    photo = one(tmp_path)
    assert (photo.camera, photo.focal_mm) == ("Canon EOS 450D", 50.0)
    # Canon's own figure: 22.2 mm wide.
    assert photo.focal_px == pytest.approx(50 / 22.2 * 160)
    assert photo.focal_source == "sensor table"


def test_focal_plane_resolution_is_the_last_source_of_focal_length(tmp_path: Path) -> None:
    # 4000 pixels at 4233.3 per inch: a sensor of 24 mm; the photo was then made ten times smaller.
    maker.write_photo(
        tmp_path / "a.jpg",
        (400, 300),
        main={0x010F: maker.text("Acme"), 0x0110: maker.text("One")},
        exif={
            0x920A: maker.rational(30.0),
            0xA002: maker.long(4000),
            0xA003: maker.long(3000),
            0xA20E: maker.rational(4000 / 24 * 25.4, 10000),
            0xA210: maker.short(2),
        },
    )
    photo = one(tmp_path)
    assert photo.focal_px == pytest.approx(30 / 24 * 400, rel=1e-5)
    assert photo.sensor_width_mm == pytest.approx(24, rel=1e-5)
    assert photo.focal_source == "focal plane resolution"


def test_cropped_photo_keeps_focal_length_in_pixels_and_is_reported(tmp_path: Path) -> None:
    maker.write_photo(
        tmp_path / "a.jpg",
        (200, 200),
        exif={0xA002: maker.long(400), 0xA003: maker.long(300), 0xA405: maker.short(36)},
    )
    folder = read_photos(tmp_path)
    assert folder.photos[0].focal_px == pytest.approx(400)
    values = by_code(folder.warnings)["photo.cropped"]
    assert (values["size"], values["original"]) == ("200 x 200", "400 x 300")


def test_photo_without_exif_is_accepted(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "a.png")
    folder = read_photos(tmp_path)
    (photo,) = folder.photos
    assert (photo.focal_px, photo.focal_source, photo.camera, photo.taken_at) == (None,) * 4
    assert folder.warnings == []


NONSENSE = {
    "zero denominators": maker.rationals((46, 1), (5, 0), (1, 0)),
    "nothing over nothing": maker.rationals((0, 0), (0, 0), (0, 0)),
    "letters": maker.text("north"),
}


@pytest.mark.parametrize("value", NONSENSE.values(), ids=NONSENSE.keys())
def test_invalid_exif_numbers_are_ignored(tmp_path: Path, value) -> None:
    maker.write_photo(
        tmp_path / "a.jpg",
        exif={0x829A: value, 0x829D: value, 0x920A: value, 0xA404: value, 0x8827: value},
        gps={**maker.at(46, 7), 6: value},
    )
    photo = one(tmp_path)
    for found in (photo.exposure_s, photo.f_number, photo.focal_mm, photo.digital_zoom, photo.iso):
        assert found is None or np.isfinite(found)
    assert photo.latitude_deg == 46


@pytest.mark.parametrize(
    ("gps", "code"),
    [
        (
            {1: maker.text("N"), 2: NONSENSE["nothing over nothing"], 3: maker.text("E")},
            "photo.position-invalid",
        ),
        (
            {**maker.at(46, 7), 1: maker.text("E"), 3: maker.text("N")},
            "photo.position-invalid",
        ),
        ({2: maker.at(46, 7)[2], 4: maker.at(46, 7)[4]}, "photo.position-invalid"),
        (maker.at(0, 0), "photo.position-without-fix"),
        (
            {**maker.at(46, 7), 2: maker.rationals((460, 1), (0, 1), (0, 1))},
            "photo.position-invalid",
        ),
        ({**maker.at(46, 7), 9: maker.text("V")}, "photo.position-without-fix"),
    ],
)
def test_impossible_position_is_dropped_and_reported(tmp_path: Path, gps, code: str) -> None:
    maker.write_photo(tmp_path / "a.jpg", gps=gps)
    folder = read_photos(tmp_path)
    assert folder.photos[0].latitude_deg is None
    assert folder.photos[0].longitude_deg is None
    assert by_code(folder.warnings)[code]["photos"] == ("a.jpg",)


@pytest.mark.parametrize(
    ("code", "altitude", "reference"),
    [
        (0, 12.0, "sea level"),
        (1, -12.0, "below sea level"),
        (2, 12.0, "ellipsoid"),
        (3, -12.0, "ellipsoid"),
    ],
)
def test_heights_state_their_reference(tmp_path: Path, code, altitude, reference) -> None:
    maker.write_photo(tmp_path / "a.jpg", gps=maker.at(46, 7, 12.0, code))
    photo = one(tmp_path)
    assert (photo.altitude_m, photo.altitude_reference) == (altitude, reference)


def test_invalid_orientation_is_reported_and_ignored(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "a.jpg", main={0x0112: maker.short(9)})
    folder = read_photos(tmp_path)
    assert folder.photos[0].orientation == 1
    assert by_code(folder.warnings)["photo.unknown-orientation"]["tag"] == 9


@pytest.mark.parametrize("seed", range(40))
def test_damaged_header_bytes_never_crash_the_reader(tmp_path: Path, seed: int) -> None:
    path = maker.write_photo(
        tmp_path / "a.jpg",
        main=CAMERA,
        exif={0x920A: maker.rational(35.0), 0xA405: maker.short(52)},
        gps=maker.at(46, 7, 3),
        xmp=maker.drone_xmp(GimbalYawDegree="+4", GimbalPitchDegree="-90"),
    )
    data = bytearray(path.read_bytes())
    rng = np.random.default_rng(seed)
    for at in rng.integers(0, min(900, len(data)), 12):
        data[at] = rng.integers(256)
    path.write_bytes(data)
    try:
        photo = one(tmp_path)
    except InputError as error:
        assert "a.jpg" in str(error)  # noqa: PT017
    else:
        assert photo.width > 0


# -- a second and a third reader -----------------------------------------------------------------
def test_exif_agrees_with_another_reader_on_real_photos(data_dir: Path) -> None:
    import exifread

    for folder in ("brighton_beach", "saint_martin", "panel17"):
        for photo in read_photos(data_dir / folder).photos[::6]:
            with photo.path.open("rb") as file:
                tags = exifread.process_file(file, details=False)

            def value(name: str, tags=tags):
                found = tags[name].values[0]
                return float(found)

            assert photo.focal_mm == pytest.approx(value("EXIF FocalLength"))
            assert photo.focal_35mm == value("EXIF FocalLengthIn35mmFilm")
            assert photo.exposure_s == pytest.approx(value("EXIF ExposureTime"))
            assert photo.iso == value("EXIF ISOSpeedRatings")
            assert str(tags["Image Model"]).strip() in (photo.camera or "")
            if "GPS GPSLatitude" in tags:
                d, m, s = map(float, tags["GPS GPSLatitude"].values)
                assert photo.latitude_deg == pytest.approx(d + m / 60 + s / 3600, abs=1e-10)


def test_brighton_drone_photos_have_camera_angles_and_position(data_dir: Path) -> None:
    folder = read_photos(data_dir / "brighton_beach")
    assert len(folder.photos) == 18
    assert (folder.skipped, folder.warnings) == ([], [])
    first = folder.photos[0]
    assert first.name == "images/DJI_0018.JPG"
    assert first.focal_px == pytest.approx(2222.22, abs=0.01)
    assert (first.yaw_deg, first.pitch_deg, first.relative_altitude_m) == (45.0, -89.9, 39.8)
    assert first.longitude_deg == pytest.approx(-91.99456, abs=1e-5)
    assert len(folder.cameras()) == 1


def test_rotated_photo_keeps_its_stored_size(data_dir: Path) -> None:
    photos = read_photos(data_dir / "saint_martin").photos
    assert [(p.width, p.height, p.orientation) for p in photos] == [(1728, 1152, 8)] * 4
    assert photos[0].f_number is None  # a lens without contacts: f/0
    assert thumbnail(photos[0], 240).shape == (240, 160, 3)


def test_masks_beside_the_folder_are_found(data_dir: Path) -> None:
    whole = read_photos(data_dir / "panel17")
    inner = read_photos(data_dir / "panel17" / "images")
    assert len(whole.photos) == len(inner.photos) == 28
    assert [p.mask for p in whole.photos] == [p.mask for p in inner.photos]
    assert all(p.mask is not None for p in whole.photos)
    assert sum(p.latitude_deg is not None for p in whole.photos) == 5
    assert len(whole.cameras()) == 2  # of two sizes
    mask = read_mask(whole.photos[0])
    assert mask is not None
    assert mask.shape == (4618, 3464)
    assert 0.3 < mask.mean() < 0.8


# -- XMP of drones -------------------------------------------------------------------------------
def test_rtk_drone_photo_has_position_accuracy(tmp_path: Path) -> None:
    maker.write_photo(
        tmp_path / "a.jpg",
        gps=maker.at(46, 7, 512.0),
        xmp=maker.drone_xmp(
            RtkStdLon="0.012",
            RtkStdLat="0.009",
            AltitudeType="RtkAlt",
            GimbalYawDegree="-131.30",
            GimbalPitchDegree="-60.0",
            GimbalRollDegree="+0.00",
            RelativeAltitude="+40.00",
        ),
    )
    photo = one(tmp_path)
    assert photo.gps_accuracy_m == pytest.approx(0.015)
    assert photo.altitude_reference == "ellipsoid"
    assert (photo.yaw_deg, photo.pitch_deg, photo.roll_deg) == (pytest.approx(228.7), -60.0, 0.0)


_FORM = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF '
    'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description rdf:about="" {}>'
    "{}</rdf:Description></rdf:RDF></x:xmpmeta>"
)


@pytest.mark.parametrize(
    ("space", "body", "angles"),
    [
        (
            'xmlns:Camera="http://pix4d.com/camera/1.0/"',
            "<Camera:Yaw>10/1</Camera:Yaw><Camera:Pitch>30</Camera:Pitch>"
            "<Camera:Roll>0</Camera:Roll>",
            (10, -60, 0),
        ),
        (
            # An aircraft that flies north and banks to the right looks to the west.
            'xmlns:Camera="http://pix4d.com/camera/1.0/"',
            "<Camera:Yaw>0</Camera:Yaw><Camera:Pitch>0</Camera:Pitch><Camera:Roll>20</Camera:Roll>",
            (270, -70, 90),
        ),
        (
            'xmlns:drone-parrot="http://www.parrot.com/drone-parrot/1.0/"',
            "<drone-parrot:CameraYawDegree>-90</drone-parrot:CameraYawDegree>"
            "<drone-parrot:CameraPitchDegree>-45.5</drone-parrot:CameraPitchDegree>"
            "<drone-parrot:CameraRollDegree>0</drone-parrot:CameraRollDegree>",
            (270, -45.5, 0),
        ),
        (
            'xmlns:s="https://www.skydio.com/drone-skydio/1.0/"',
            '<s:CameraOrientationNED s:Roll="1" s:Pitch="-80" s:Yaw="5"/>',
            (5, -80, 1),
        ),
        (
            'xmlns:s="https://www.skydio.com/drone-skydio/1.0/"',
            '<s:CameraOrientationNED rdf:parseType="Resource"><s:Roll>1</s:Roll>'
            "<s:Pitch>-80</s:Pitch><s:Yaw>5</s:Yaw></s:CameraOrientationNED>",
            (5, -80, 1),
        ),
        (
            'xmlns:Camera="http://pix4d.com/camera/1.0/"',
            "<Camera:Yaw>0</Camera:Yaw><Camera:Pitch>0</Camera:Pitch><Camera:Roll>0</Camera:Roll>",
            (0, -90, 0),
        ),
    ],
)
def test_angles_of_all_makers_use_one_convention(space: str, body: str, angles) -> None:
    tags = read_drone_tags(_FORM.format(space, body))
    assert (tags.yaw_deg, tags.pitch_deg, tags.roll_deg) == pytest.approx(angles, abs=1e-9)


@pytest.mark.parametrize(
    "packet",
    [
        b"",
        b"<x:xmpmeta",
        b"<x:xmpmeta></rdf></x:xmpmeta>",
        b'<!DOCTYPE a [<!ENTITY b "c">]><x:xmpmeta>&b;</x:xmpmeta>',
        b"\xff\xfe<x:xmpmeta>\x00</x:xmpmeta>",
        _FORM.format("", "<rdf:li>" * 5000 + "</rdf:li>" * 5000).encode(),
        None,
    ],
)
def test_damaged_xmp_packet_gives_no_angles(packet) -> None:
    assert read_drone_tags(packet).yaw_deg is None


def test_a_panorama_is_not_taken_for_a_photo(tmp_path: Path) -> None:
    packet = _FORM.format(
        'xmlns:GPano="http://ns.google.com/photos/1.0/panorama/"',
        "<GPano:ProjectionType>equirectangular</GPano:ProjectionType>",
    )
    maker.write_photo(tmp_path / "pano.jpg", xmp=packet.encode())
    with refused("photo.none-usable", NoPhotosError) as error:
        read_photos(tmp_path)
    assert "panorama" in error.value.values["reason"]


# -- folders -------------------------------------------------------------------------------------
def test_photos_are_sorted_by_number(tmp_path: Path) -> None:
    for i in (10, 9, 1):
        maker.write_photo(tmp_path / f"IMG_{i}.jpg", seed=i)
    maker.write_photo(tmp_path / "below" / "z.JPG", seed=4)
    names = [p.name for p in read_photos(tmp_path).photos]
    assert names == ["below/z.JPG", "IMG_1.jpg", "IMG_9.jpg", "IMG_10.jpg"]


def test_unusable_files_are_skipped_with_a_reason(tmp_path: Path) -> None:
    good = maker.write_photo(tmp_path / "good.jpg", (640, 480), seed=1)
    data = good.read_bytes()
    (tmp_path / "half.jpg").write_bytes(data[: len(data) // 2])
    (tmp_path / "empty.jpg").write_bytes(b"")
    (tmp_path / "text.png").write_text("not a picture")
    (tmp_path / "again.jpg").write_bytes(data)
    (tmp_path / "phone.avif").write_bytes(b"x")
    (tmp_path / "walk.mp4").write_bytes(b"x")
    (tmp_path / "good.CR2").write_bytes(b"raw beside its JPEG")
    (tmp_path / "notes.txt").write_text("12 Nov, rain")
    Image.new("CMYK", (20, 20)).save(tmp_path / "print.jpg")
    Image.fromarray(np.ones((9, 9), np.float32)).save(tmp_path / "dem.tif")
    folder = read_photos(tmp_path)
    # Two names for one file: the first in order is kept.
    assert [p.name for p in folder.photos] == ["again.jpg"]
    assert folder.duplicates == [("good.jpg", "again.jpg")]
    reasons = dict(folder.skipped)
    for name, code in {
        "good.jpg": "photo.duplicate",
        "half.jpg": "photo.truncated",
        "empty.jpg": "file.empty",
        "text.png": "picture.unknown-kind",
        "phone.avif": "photo.avif",
        "walk.mp4": "photo.video",
        "print.jpg": "photo.colors",
        "dem.tif": "photo.raster",
    }.items():
        assert reasons[name].code == code
    assert "notes.txt" not in reasons
    assert "good.CR2" not in reasons


def test_broken_links_are_skipped_and_reported(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "写真 1.jpg")
    (tmp_path / "gone.jpg").symlink_to(tmp_path / "elsewhere" / "gone.jpg")
    found = read_photos(tmp_path)
    assert [photo.name for photo in found.photos] == ["写真 1.jpg"]
    ((name, reason),) = found.skipped
    assert name == "gone.jpg"
    assert reason.code == "file.missing"


def test_undecodable_file_names_are_skipped_and_reported(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "a.jpg")
    try:
        maker.write_photo(tmp_path / os.fsdecode(b"b\xff.jpg"), seed=2)
    except OSError:
        pytest.skip("this disk takes no such names")
    found = read_photos(tmp_path)
    assert [photo.name for photo in found.photos] == ["a.jpg"]
    ((other, reason),) = found.skipped
    assert reason.code == "file.name-encoding"
    assert other.encode()


@pytest.mark.parametrize("cut", [0.2, 0.5, 0.9, 0.999])
def test_truncated_jpeg_is_detected_despite_complete_thumbnail(tmp_path: Path, cut: float):
    import io

    small = io.BytesIO()
    Image.fromarray(maker.picture(40, 30)).save(small, "JPEG")
    path = maker.write_photo(
        tmp_path / "a.jpg", (640, 480), exif={0x927C: (7, len(small.getvalue()), small.getvalue())}
    )
    data = path.read_bytes()
    assert data.count(b"\xff\xd9") == 2
    assert one(tmp_path).width == 640
    path.write_bytes(data + b"what a camera adds" * 9999)
    assert one(tmp_path).width == 640
    path.write_bytes(data[: int(len(data) * cut)])
    with pytest.raises(NoPhotosError):
        read_photos(tmp_path)


@pytest.mark.parametrize(
    "name",
    ["a_mask.png", "a.jpg.mask.png", "a.mask.png", "masks/a.png", "masks/a_mask.PNG"],
)
def test_masks_are_found_under_every_usual_name(tmp_path: Path, name: str) -> None:
    maker.write_photo(tmp_path / "a.jpg", (40, 30))
    maker.write_photo(tmp_path / "b.jpg", (40, 30), seed=2)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    half = np.zeros((30, 40), np.uint8)
    half[:, :20] = 255
    Image.fromarray(half).save(tmp_path / name)
    folder = read_photos(tmp_path)
    assert [p.name for p in folder.photos] == ["a.jpg", "b.jpg"]
    assert folder.photos[0].mask == tmp_path / name
    assert folder.photos[1].mask is None
    assert (folder.warnings, folder.skipped) == ([], [])
    mask = read_mask(folder.photos[0])
    assert mask is not None
    assert np.array_equal(mask, half > 0)
    assert read_mask(folder.photos[1]) is None


@pytest.mark.parametrize(
    ("size", "kept", "code"),
    [((80, 60), True, "mask.scaled"), ((30, 40), False, "mask.other-shape")],
)
def test_mask_of_other_size_is_resized_or_rejected(
    tmp_path: Path, size, kept: bool, code: str
) -> None:
    maker.write_photo(tmp_path / "a.jpg", (40, 30))
    Image.new("L", size, 255).save(tmp_path / "a_mask.png")
    folder = read_photos(tmp_path)
    assert (folder.photos[0].mask is not None) == kept
    assert code in by_code(folder.warnings)
    if kept:
        mask = read_mask(folder.photos[0])
        assert mask is not None
        assert mask.shape == (30, 40)


def test_mask_without_photo_is_reported(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "a.jpg")
    Image.new("L", (9, 9)).save(tmp_path / "other_mask.png")
    ((name, reason),) = read_photos(tmp_path).skipped
    assert (name, reason.code) == ("other_mask.png", "mask.without-photo")


def test_missing_folder_empty_folder_and_file_are_rejected(tmp_path: Path) -> None:
    with refused("folder.missing"):
        read_photos(tmp_path / "missing")
    (tmp_path / "file.txt").write_text("x")
    with refused("folder.not-a-folder"):
        read_photos(tmp_path / "file.txt")
    with refused("photo.only-other-files", NoPhotosError, count=1):
        read_photos(tmp_path)


def test_the_textures_of_a_model_and_hidden_folders_are_not_photos(tmp_path: Path) -> None:
    maker.write_photo(tmp_path / "a.jpg")
    maker.write_photo(tmp_path / "model" / "texture.jpg", seed=2)
    (tmp_path / "model" / "m.mtl").write_text("")
    maker.write_photo(tmp_path / ".thumbs" / "t.jpg", seed=3)
    maker.write_photo(tmp_path / "p.vom" / "t.jpg", seed=4)
    assert [p.name for p in read_photos(tmp_path).photos] == ["a.jpg"]


def test_a_hundred_megapixels_are_listed_without_being_decoded(tmp_path: Path) -> None:
    Image.new("L", (12_000, 9_000)).save(tmp_path / "huge.jpg")
    start = time.perf_counter()
    photo = one(tmp_path)
    assert time.perf_counter() - start < 0.25
    assert photo.width * photo.height == 108e6
    assert thumbnail(photo, 200).shape == (150, 200, 3)


def test_reading_photos_can_be_cancelled(tmp_path: Path) -> None:
    from vomstudio.core.errors import Cancelled
    from vomstudio.core.progress import CancelToken, SilentProgress

    maker.write_photo(tmp_path / "a.jpg")
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        read_photos(tmp_path, SilentProgress(token))


# -- pixels --------------------------------------------------------------------------------------
@pytest.mark.parametrize("orientation", range(1, 9))
def test_thumbnails_are_rotated_upright_like_pillow(tmp_path: Path, orientation: int) -> None:
    from PIL import ImageOps

    maker.write_photo(tmp_path / "a.png", (40, 30), main={0x0112: maker.short(orientation)})
    with Image.open(tmp_path / "a.png") as image:
        image.getexif()[0x0112] = orientation
        expected = np.asarray(ImageOps.exif_transpose(image))
        stored = np.asarray(image)
    assert np.array_equal(rotate_upright(stored, orientation), expected)
    assert np.array_equal(thumbnail(one(tmp_path), 64), expected)
    # Grey values for measuring stay as they are stored.
    assert grey(one(tmp_path)).shape == (30, 40)


def test_sixteen_bit_images_use_their_upper_eight_bits(tmp_path: Path) -> None:
    values = (np.arange(64 * 64).reshape(64, 64) * 16).astype(np.uint16)
    Image.fromarray(values).save(tmp_path / "a.png")
    assert np.array_equal(grey(one(tmp_path)), values >> 8)


def test_sixteen_bit_color_tiff_is_read(tmp_path: Path) -> None:
    import cv2

    values = np.full((20, 30, 3), 200 << 8, np.uint16)
    cv2.imwrite(str(tmp_path / "a.tif"), values)
    assert np.array_equal(thumbnail(one(tmp_path), 64), np.full((20, 30, 3), 200, np.uint8))


def test_damaged_pixels_raise_error_with_file_name(tmp_path: Path) -> None:
    path = maker.write_photo(tmp_path / "a.png", (300, 300))
    data = path.read_bytes()
    half = len(data) // 2
    path.write_bytes(data[:half] + bytes(255 - b for b in data[half : half + 200]))
    for function in (thumbnail, grey):
        with refused("file.damaged", file=path):
            function(path)


# -- the table of cameras ------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "width"),
    [
        ("NIKON D90", 23.6),
        ("nikon d90", 23.6),
        ("Canon EOS 450D", 22.2),
        ("EOS 450D", None),
        ("SONY DSC-W530", 6.17),
        ("dsc w530", 6.17),
        ("DJI Mini 2", 6.17),
        ("FC3411", 13.2),
        ("nothing like it", None),
        ("", None),
        (None, None),
    ],
)
def test_cameras_are_found_by_common_names(name, width) -> None:
    found = find_camera(name)
    assert (found.width_mm if found else None) == width


def test_the_cameras_of_the_textbook_are_in_the_table() -> None:
    # Exercises 1, 2 and 5, with the sizes of photo that it states.
    for name, width in (("SONY DSC-W530", 4320), ("Canon EOS 450D", 4272), ("Air 2S", 5472)):
        found = find_camera(name)
        assert found is not None
        assert found.width_px == width
    assert "NIKON D90" in similar_cameras("D90")
    assert all(name.startswith("DJI") for name in similar_cameras("DJI"))
    assert len(similar_cameras("DJI")) == 5


def test_every_row_of_the_table_describes_a_possible_camera() -> None:
    models = camera_models()
    assert len(models) > 150
    names = [name for model in models for name in model.names]
    assert len(names) == len(set(names))
    for model in models:
        # Pixels are square, to what makers round; sensors and pixels have possible sizes.
        pitch = model.width_mm / model.width_px, model.height_mm / model.height_px
        assert pitch[0] == pytest.approx(pitch[1], rel=0.03), model.label
        assert 0.0005 < pitch[0] < 0.01, model.label
        if model.focal_mm is not None:
            assert 0.4 < model.focal_mm / model.width_mm < 2.0, model.label


def test_the_table_agrees_with_the_35_mm_value_of_a_real_camera(data_dir: Path) -> None:
    photo = read_photos(data_dir / "saint_martin").photos[0]
    model = find_camera(photo.camera)
    assert model is not None
    assert photo.sensor_width_mm == pytest.approx(model.width_mm, rel=0.02)


def test_copied_photo_set_is_read_identically(tmp_path: Path, data_dir: Path) -> None:
    shutil.copytree(data_dir / "saint_martin", tmp_path / "a" / "saint_martin")
    folder = read_photos(tmp_path / "a")
    assert folder.photos[0].name == "saint_martin/IMGP4167.JPG"
    assert len(folder.photos) == 4


@pytest.mark.parametrize("orientation", range(1, 9))
def test_marks_rotate_with_the_image(orientation: int) -> None:
    from vomstudio.io.photos.pixels import rotate_pixels_upright, rotate_upright

    picture = np.zeros((5, 7), np.uint8)
    picture[1, 4] = 255
    upright = rotate_upright(picture, orientation)
    ((x, y),) = rotate_pixels_upright([[4.5, 1.5]], orientation, 7, 5)
    assert upright[int(y), int(x)] == 255
    assert (x % 1, y % 1) == (0.5, 0.5)
