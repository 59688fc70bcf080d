"""How models come to their place in World by measurement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from vomstudio.geometry.frames import UNDECLARED, Frame
from vomstudio.geometry.matrices import IDENTITY, Matrix, Point

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray

NorthKind = Literal["grid", "true", "magnetic"]
Method = Literal["gps", "control", "local", "points", "attitudes", "lines", "reference"]


@dataclass(frozen=True)
class ReadNorth:
    """How azimuths were counted by which a model was placed.

    turned_deg: what was added to them, to count them from the north of the map. declination_deg:
    that was used, None where none was needed; stated: it was not taken from a model of the Earth's
    field. day: as of `Compass`. doubt_deg: one sigma, of all alike.
    """

    north: NorthKind
    turned_deg: float = 0.0
    declination_deg: float | None = None
    stated: bool = False
    day: str = ""
    doubt_deg: float = 0.0


@dataclass(frozen=True)
class RegistrationPoint:
    """A point by which a model was placed, or which judges that.

    model : in the file's frame; world : as given; residual : fitted less given, World; sigma_m :
    (east, north, up) as stated, None where not; check : it took no part
    """

    label: str
    model: Point
    world: Point
    residual: Point
    sigma_m: Point | None = None
    check: bool = False


@dataclass(frozen=True)
class ObservationGroup:
    """Observations of one kind that a registration was computed from.

    Parameters
    ----------
    kind : str
        "points", "cameras", "attitudes", "verticals", "lengths", "level_lines", "plumb_lines",
        "photo_upright", "azimuths", "compass", "reference" or "kept_scale".
    labels : tuple of str
        Name of each observation.
    """

    kind: str
    labels: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """Number of observations."""
        return len(self.labels)


@dataclass(frozen=True)
class Registration:
    """A similarity from a model's file to World, found by measurement and not declared.

    method: "gps", "control" or "local" for a model placed by the positions of its cameras, by
    control points marked in photos, or by nothing outside of the photos; "attitudes" for one
    placed by the attitudes of its cameras; "points" for a model placed by points that were
    found on it, "lines" by lines and planes alone of which something is known, "reference" for one
    fitted to another model. frame: what is known of World afterwards. matrix: 4x4 from the file to
    World. reconstruction_id: the one that it came with, "" for none.
    rotation_error_deg: about up, east and north, one sigma, None where not known; scale_error: one
    sigma, as a share. rms_control_m, rms_check_m: of what is left over at the points. control: by
    which it was found. covariance: 7x7 of turns about east, north and up (rad), a relative change
    of scale and a shift (m), about `centre` in World, None where only the three errors are known.
    reach_m, normal: from the middle of the model to its edge, and of its mean plane, World
    (`geology.bowing.model_shape`); None where only its points are known. lens_bowing95_deg,
    lens_stretch95: what the errors of the lenses of a model made here can do, 95 %: by how much
    dips differ from edge to edge, and depths beside lengths, as a share; None where not known.
    read_north: from which north azimuths were read that it rests on, None where it rests on none.
    observations: the inputs of the adjustment by kind, empty if they are not known.
    click_sigma_m: error of each coordinate of a click on the model that was used, metres, one
    sigma; None if it is not known.
    """

    id: str
    name: str
    method: Method
    frame: Frame = UNDECLARED
    matrix: Matrix = IDENTITY
    reconstruction_id: str = ""
    rotation_error_deg: tuple[float, float, float] | None = None
    scale_error: float | None = None
    rms_control_m: float | None = None
    rms_check_m: float | None = None
    control: tuple[RegistrationPoint, ...] = ()
    covariance: tuple[tuple[float, ...], ...] | None = None
    centre: Point | None = None
    reach_m: float | None = None
    normal: Point | None = None
    lens_bowing95_deg: float | None = None
    lens_stretch95: float | None = None
    read_north: ReadNorth | None = None
    observations: tuple[ObservationGroup, ...] = ()
    click_sigma_m: float | None = None

    def to_world(self) -> Matrix:
        """4x4 similarity from the file to World."""
        return self.matrix

    def rotation_covariance(self) -> FloatArray | None:
        """(3, 3) radians squared, of turns about east, north and up; None where not known."""
        import numpy as np

        if self.covariance is not None:
            return np.array(self.covariance, np.float64)[:3, :3]
        if self.rotation_error_deg is None:
            return None
        up, east, north = np.radians(self.rotation_error_deg)
        return np.diag([east**2, north**2, up**2])

    def shape_covariance(self) -> FloatArray | None:
        """(4, 4) of the same turns, radians, and of a relative change of scale; None where not
        known."""
        import numpy as np

        if self.covariance is not None:
            return np.array(self.covariance, np.float64)[:4, :4]
        rotation = self.rotation_covariance()
        if rotation is None or self.scale_error is None:
            return None
        shape = np.zeros((4, 4))
        shape[:3, :3], shape[3, 3] = rotation, self.scale_error**2
        return shape

    def placing_error_m(self, bounds: FloatArray) -> float | None:
        """How far the model may be off because of it, one sigma along any direction, metres: the
        mean (RMS) over the corners of its box in World (2, 3), else that of check or control
        points; None where neither is known."""
        import numpy as np

        if self.covariance is not None and self.centre is not None:
            known = np.array(self.covariance, np.float64)
            total = 0.0
            for which in np.ndindex(2, 2, 2):
                x, y, z = np.where(which, bounds[1], bounds[0]) - self.centre
                # A turn w moves the corner by w x p, a growth along p.
                moves = np.hstack(
                    [
                        [[0, z, -y, x], [-z, 0, x, y], [y, -x, 0, z]],
                        np.eye(3),
                    ]
                )
                total += float(np.trace(moves @ known @ moves.T))
            return float(np.sqrt(max(total, 0.0) / 8.0 / 3.0))
        rms = self.rms_check_m or self.rms_control_m
        return None if rms is None else float(rms / np.sqrt(3.0))
