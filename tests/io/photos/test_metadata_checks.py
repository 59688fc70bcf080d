"""Photo metadata that contradict each other, are not measurements, or are written as a comment."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.io.photos import photo_maker as maker
from vomstudio.core.findings import Finding
from vomstudio.io.photos.metadata_checks import signed_altitude
from vomstudio.io.photos.reading import PhotoFolder, read_photo, read_photos
from vomstudio.io.photos.user_comment import comment_angles, comment_text

CAMERA = {0x010F: maker.text("DJI"), 0x0110: maker.text("FC6310")}
NO_ANGLES = {"GimbalYawDegree": "+0.00", "GimbalPitchDegree": "+0.00", "GimbalRollDegree": "+0.00"}


def findings(folder: PhotoFolder) -> dict[str, Finding]:
    return {each.code: each for each in folder.warnings if isinstance(each, Finding)}


# --- heights ---------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("exif", "xmp", "used"),
    [
        (-50.33, 50.33, 50.33),  # "below sea level" in EXIF alone
        (50.33, -50.33, -50.33),
        (-50.3, 50.33, 50.33),  # rounded differently
        (-400.0, -400.0, -400.0),  # the Dead Sea
        (-5.0, 40.0, -5.0),  # heights above other surfaces
        (0.2, -0.2, 0.2),
        (-50.33, None, -50.33),
        (None, 50.33, None),
    ],
)
def test_xmp_height_sign_is_used_if_magnitudes_agree(exif, xmp, used) -> None:
    assert signed_altitude(exif, xmp) == used


def test_contradicting_heights_are_reported_once_per_folder(tmp_path: Path) -> None:
    for i in range(3):
        maker.write_photo(
            tmp_path / f"{i}.jpg",
            seed=i,
            main=CAMERA,
            gps=maker.at(47, 12, 50.33, 1),
            xmp=maker.drone_xmp(AbsoluteAltitude="+50.33", RelativeAltitude="+30.10"),
        )
    folder = read_photos(tmp_path)
    assert [p.altitude_m for p in folder.photos] == [50.33] * 3
    assert {p.altitude_reference for p in folder.photos} == {"sea level"}
    found = findings(folder)["photo.altitude-sign"].values
    assert found == {"photos": 3, "photo": "0.jpg", "exif_m": -50.33, "xmp_m": 50.33}


# --- angles that are 0 -----------------------------------------------------------------------
def test_angles_that_are_zero_in_all_photos_of_a_camera_are_not_used(tmp_path: Path) -> None:
    for i in range(3):
        maker.write_photo(
            tmp_path / f"{i}.jpg", seed=i, main=CAMERA, xmp=maker.drone_xmp(**NO_ANGLES)
        )
    other = {0x0110: maker.text("Other")}
    angles = {"GimbalYawDegree": "12.0", "GimbalPitchDegree": "-3.0", "GimbalRollDegree": "0.0"}
    maker.write_photo(tmp_path / "9.jpg", seed=9, main=other, xmp=maker.drone_xmp(**angles))
    folder = read_photos(tmp_path)
    assert [p.yaw_deg for p in folder.photos] == [None, None, None, 12.0]
    assert findings(folder)["photo.angles-not-measured"].values == {"photos": 3, "photo": "0.jpg"}


def test_single_zero_angle_photo_among_others_keeps_its_angles(tmp_path: Path) -> None:
    for i, yaw in enumerate(("+0.00", "+30.00")):
        tags = NO_ANGLES | {"GimbalYawDegree": yaw}
        maker.write_photo(tmp_path / f"{i}.jpg", seed=i, main=CAMERA, xmp=maker.drone_xmp(**tags))
    folder = read_photos(tmp_path)
    assert [p.yaw_deg for p in folder.photos] == [0.0, 30.0]
    assert not findings(folder)


# --- angles in UserComment -------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "angles"),
    [
        ("Roll 1.5 Pitch -8.0 Yaw 120.0", (120.0, -8.0, 1.5)),
        ("Pitch: -8.0, Yaw: 120.0, Roll: 1.5", (120.0, -8.0, 1.5)),
        ("yaw=120;pitch=-8;roll=1.5", (120.0, -8.0, 1.5)),
        ("pitch:-8.0 yaw:-120 roll:1e0", (-120.0, -8.0, 1.0)),
        ('{"roll": 1.5, "pitch": -8, "yaw": 120, "latitude": 47.1}', (120.0, -8.0, 1.5)),
        (
            '{"XMPdata":{"CameraYaw":"120","CameraPitch":"-8","CameraRoll":"1.5"}}',
            (120.0, -8.0, 1.5),
        ),
        ('text {% {"camera_pan": 120, "camera_tilt": -8} %}', (120.0, -8.0, None)),
        ("FlightYaw: 7 FlightPitch: 9 GimbalYawDegree=120 GimbalPitchDegree=-8", (120, -8, None)),
        ("Yaw (deg): 120, Pitch (deg): -8, Roll (deg): 1.5", (120.0, -8.0, 1.5)),
        ("Heading: 120 Pitch: -8", (120.0, -8.0, None)),
        ("FlightYaw: 7, FlightPitch: 9, FlightRoll: 1", None),  # of the aircraft
        ("yaw: 1, yaw: 2, pitch: 3", None),
        ("yaw: 120", None),
        ("yaw: 120 pitch: 170", None),
        ("the yawning pitch of a roll 3", None),
        ("", None),
    ],
)
def test_angles_are_parsed_from_common_comment_forms(text: str, angles) -> None:
    assert comment_angles(text) == angles


@pytest.mark.parametrize(
    "text", ["yaw" + " " * 60_000 + "x", "yaw " * 16_000, "yaw" + "9" * 60_000, "yaw(" * 15_000]
)
def test_comments_without_angles_are_parsed_quickly(text: str) -> None:
    assert comment_angles(text) is None


@pytest.mark.parametrize(
    "raw",
    [
        b"ASCII\0\0\0Yaw: 5 Pitch: 1\0\0",
        b"UNICODE\0" + "Yaw: 5 Pitch: 1".encode("utf-16-le"),
        b"UNICODE\0" + "Yaw: 5 Pitch: 1".encode("utf-16-be"),
        b"UNICODE\0" + "Yaw: 5 Pitch: 1".encode("utf-16"),
        bytes(8) + b"Yaw: 5 Pitch: 1",
        b"Yaw: 5 Pitch: 1",
        "Yaw: 5 Pitch: 1",
    ],
)
def test_comment_encodings_are_decoded(raw: bytes | str) -> None:
    assert comment_text(raw) == "Yaw: 5 Pitch: 1"


def comment(text: str) -> dict[int, tuple[int, int, bytes]]:
    data = b"ASCII\0\0\0" + text.encode()
    return {0x9286: (7, len(data), data)}


def test_comment_angles_are_used_if_maker_tags_have_none(tmp_path: Path) -> None:
    said = comment("Yaw: -120.0, Pitch: -8.0, Roll: 1.5")
    path = maker.write_photo(tmp_path / "a.jpg", exif=said)
    photo = read_photo(path)
    assert (photo.yaw_deg, photo.pitch_deg, photo.roll_deg) == (240.0, -8.0, 1.5)
    tags = {"GimbalYawDegree": "12.0", "GimbalPitchDegree": "-3.0", "GimbalRollDegree": "0.0"}
    path = maker.write_photo(tmp_path / "b.jpg", seed=1, exif=said, xmp=maker.drone_xmp(**tags))
    assert read_photo(path).yaw_deg == 12.0
    # A gimbal that did not report is no better than none.
    path = maker.write_photo(
        tmp_path / "c.jpg", seed=2, exif=said, xmp=maker.drone_xmp(**NO_ANGLES)
    )
    assert read_photo(path).yaw_deg == 240.0
    folder = read_photos(tmp_path)
    found = findings(folder)["photo.angles-in-comment"]
    assert (found.severity, found.values["photos"]) == ("info", 2)


def test_zero_angles_in_comments_are_ignored_too(tmp_path: Path) -> None:
    for i in range(2):
        said = comment("Roll 0.0 Pitch 0.0 Yaw 0.0")
        maker.write_photo(tmp_path / f"{i}.jpg", seed=i, exif=said)
    folder = read_photos(tmp_path)
    assert {p.yaw_deg for p in folder.photos} == {None}
    assert set(findings(folder)) == {"photo.angles-not-measured"}
