"""What a camera writes into its photos."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
from PIL import Image
from PIL.TiffImagePlugin import IFDRational
from pyproj import Transformer

from . import camera, geology
from .camera import Shot
from .geology import Array

BEGIN = datetime(2024, 5, 17, 14, 21, 8)


def words(shot: Shot, position: Array, sd: float) -> Image.Exif:
    """EXIF of a photo. position (3,): where its receiver thinks it was, relative to ORIGIN, its
    coordinates uncertain by sd m each."""
    exif = Image.Exif()
    when = (BEGIN + timedelta(seconds=shot.seconds)).strftime("%Y:%m:%d %H:%M:%S")
    exif[0x010F], exif[0x0110] = camera.MAKE, camera.MODEL
    exif[0x0112] = 1  # stored upright
    exif[0x0131] = "sample outcrop"
    exif[0x0132] = when
    own = exif.get_ifd(0x8769)
    own[0x829A] = IFDRational(1, round(500 / shot.exposure))
    own[0x829D] = IFDRational(8, 1)
    own[0x8827] = 100
    own[0x9003] = own[0x9004] = when
    own[0x920A] = IFDRational(round(10 * camera.FOCAL_MM), 10)
    own[0xA002], own[0xA003] = camera.WIDTH, camera.HEIGHT
    own[0xA405] = camera.FOCAL_35_MM
    own[0xA404] = IFDRational(1, 1)
    own[0xA434] = "Handlens 18mm F2.8"
    east, north, up = position + geology.ORIGIN
    to_degrees = Transformer.from_crs(geology.EPSG, 4326, always_xy=True)
    longitude, latitude = to_degrees.transform(east, north)
    gps = exif.get_ifd(0x8825)
    gps[0] = b"\x02\x03\x00\x00"
    gps[1], gps[2] = "N" if latitude >= 0 else "S", _sexagesimal(abs(latitude))
    gps[3], gps[4] = "E" if longitude >= 0 else "W", _sexagesimal(abs(longitude))
    gps[5], gps[6] = b"\x00", IFDRational(round(100 * up), 100)
    gps[18] = "WGS-84"
    gps[31] = IFDRational(round(100 * sd), 100)
    return exif


def _sexagesimal(degrees: float) -> tuple[IFDRational, IFDRational, IFDRational]:
    whole = int(degrees)
    minutes = int((degrees - whole) * 60)
    seconds = ((degrees - whole) * 60 - minutes) * 60
    return (
        IFDRational(whole, 1),
        IFDRational(minutes, 1),
        IFDRational(int(np.round(seconds * 100_000)), 100_000),
    )
