"""Options of plans and checks of photo surveys, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import MAX_LENGTH_M, MIN_LENGTH_M, Options, option
from vomstudio.core.words import to_translate

MIN_OVERLAP, MAX_OVERLAP = 0.6, 0.95
DEFAULT_APERTURE = 8.0
DEFAULT_FPS = 2.0
MIN_ERROR_M = 1e-6
DEFAULT_RECEIVER_M = 3.0
"""Standard deviation of a horizontal coordinate by a phone or a drone without RTK."""
DEFAULT_CONTROL_M = 0.02
"""Standard deviation of a coordinate of control points by RTK or total station."""


@dataclass(frozen=True)
class PlanOptions(Options):
    """Outcrop, distance and camera settings of a survey to plan.

    Raises
    ------
    UsageError
        If a value is out of bounds.
    """

    width_m: float = option(
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Width"),
        help=to_translate("width of the outcrop, m"),
        tip=to_translate("Width of the outcrop"),
        decimals=1,
    )
    height_m: float = option(
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Height"),
        help=to_translate("height of the outcrop, m"),
        tip=to_translate("Height of the outcrop"),
        decimals=1,
    )
    distance_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Distance"),
        help=to_translate("distance from the camera to the rock, m"),
        tip=to_translate("Distance from the camera to the rock"),
        decimals=2,
    )
    gsd_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Pixel size"),
        help=to_translate("required size of a pixel on the rock, m"),
        tip=to_translate("Size of a pixel on the rock"),
        decimals=2,
        form_unit=("mm", 1000.0),
    )
    plane_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Smallest plane"),
        help=to_translate("size of the smallest plane to measure (1000 pixels across), m"),
        tip=to_translate("Size of the smallest plane to measure"),
        decimals=2,
    )
    manner: Literal["handheld", "drone", "terrain"] = option(
        "handheld",
        label=to_translate("Method"),
        help=to_translate(
            "how the photos are taken: on foot, by drone in front of a cliff, or by drone over"
            " flat ground"
        ),
        tip=to_translate("How the photos are taken"),
        titles=(
            to_translate("Hand-held camera"),
            to_translate("Drone in front of a cliff"),
            to_translate("Drone over flat ground"),
        ),
    )
    overlap: float = option(
        0.7,
        minimum=MIN_OVERLAP,
        maximum=MAX_OVERLAP,
        metavar="SHARE",
        label=to_translate("Overlap"),
        help=to_translate("overlap of neighbouring photos, 0.6 to 0.95"),
        tip=to_translate("Overlap of neighbouring photos"),
        decimals=0,
        form_unit=("%", 100.0),
    )
    focal_mm: float | None = option(
        None,
        minimum=0.1,
        maximum=1e5,
        label=to_translate("Focal length"),
        help=to_translate("focal length of the lens, mm"),
        tip=to_translate("Focal length of an interchangeable lens"),
        decimals=1,
        empty_text=to_translate("fixed lens"),
    )
    aperture: float | None = option(
        None,
        minimum=0.5,
        maximum=128.0,
        metavar="N",
        label=to_translate("F-number"),
        help=to_translate("f-number, if the aperture is adjustable"),
        tip=to_translate("F-number, if the aperture is adjustable"),
        automatic_text=to_translate("8"),
        decimals=1,
    )
    receiver_m: float | None = option(
        None,
        minimum=MIN_ERROR_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Receiver error"),
        help=to_translate(
            "horizontal standard deviation of the camera's receiver, m; twice this value is"
            " assumed for heights"
        ),
        tip=to_translate("Horizontal error (1σ): 3 m without RTK, 0.02 m with RTK"),
        automatic_text=to_translate("3"),
    )
    control_m: float | None = option(
        None,
        minimum=MIN_ERROR_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Control error"),
        help=to_translate("standard deviation of control point coordinates, m"),
        tip=to_translate("Standard deviation of a control point coordinate"),
        automatic_text=to_translate("0.02"),
    )


@dataclass(frozen=True)
class CheckOptions(Options):
    """Known distance of photos to check. Raises UsageError if a value is out of bounds."""

    distance_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("distance from the camera to the rock, m"),
        automatic_text=to_translate("flying height, if the camera points down"),
    )


@dataclass(frozen=True)
class CheckScene(Options):
    """Model made from the checked photos; an option of the command only."""

    scene: str | None = option(
        None,
        metavar="DIR",
        help=to_translate("folder of a model made from these photos, to check its alignment too"),
    )


@dataclass(frozen=True)
class VideoFrameOptions(Options):
    """Frames to take from a video. Raises UsageError if a value is out of bounds."""

    fps: float = option(
        DEFAULT_FPS,
        minimum=0.05,
        maximum=10.0,
        metavar="N",
        label=to_translate("Frames per second"),
        help=to_translate("frames to extract per second; 1 to 4 are usual"),
        tip=to_translate("1 to 4 are usual; more for fast motion"),
        decimals=1,
    )
