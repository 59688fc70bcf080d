"""Registrations, which are measured placements of models in the World frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.matrices import IDENTITY, Matrix, Point

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray

NorthKind = Literal["grid", "true", "magnetic"]
Method = Literal["gps", "control", "local", "points", "attitudes", "lines", "reference"]


@dataclass(frozen=True)
class NorthReference:
    """North reference of the azimuths by which a model was placed.

    Attributes
    ----------
    turned_deg : float
        Correction from this north to grid north, degrees.
    declination_deg : float or None
        Declination used, degrees, or None if it is not needed.
    stated : bool
        Whether the declination was stated instead of computed from a model of the Earth's field.
    day : str
        See `Compass`.
    doubt_deg : float
        Standard deviation common to all azimuths, degrees.
    """

    north: NorthKind
    turned_deg: float = 0.0
    declination_deg: float | None = None
    stated: bool = False
    day: str = ""
    doubt_deg: float = 0.0


@dataclass(frozen=True)
class RegistrationPoint:
    """Control point used to place a model, or check point.

    Attributes
    ----------
    model : Point
        Point in the file frame.
    world : Point
        Given coordinates in the World frame.
    residual : Point
        Residual (fitted minus given) in the World frame, m.
    sigma_m : Point or None
        Stated errors (east, north, up), m.
    check : bool
        Whether this is a check point, which is not used in the fit.
    """

    label: str
    model: Point
    world: Point
    residual: Point
    sigma_m: Point | None = None
    check: bool = False


@dataclass(frozen=True)
class ObservationGroup:
    """Observations of one kind from which a registration was computed.

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
    """Measured (not declared) similarity from the file frame of a model to the World frame.

    Attributes
    ----------
    method : str
        Basis of the placement. "gps": camera positions. "control": control points marked in photos.
        "local": the photos alone. "attitudes": attitudes of the cameras. "points": points picked on
        the model. "lines": known lines and planes alone. "reference": fit to another model.
    frame : Frame
        World frame.
    matrix : Matrix
        4x4 matrix from the file frame to the World frame.
    reconstruction_id : str
        Id of the reconstruction, or "" for a model without a reconstruction.
    rotation_error_deg : (float, float, float) or None
        One-sigma errors about up, east and north, degrees.
    scale_error : float or None
        Relative one-sigma error of the scale.
    rms_control_m, rms_check_m : float or None
        RMS residual of the points, m.
    control : tuple of RegistrationPoint
    covariance : (7, 7) tuple or None
        Covariance of rotations about east, north and up (rad), relative scale and shift (m), about
        `centre` in the World frame; None if only the three errors are known.
    reach_m, normal : float, Point or None
        Distance from the centre of the model to its edge, and normal of its mean plane in the World
        frame (`geology.bowing.model_shape`); None if only points of the model are known.
    lens_bowing95_deg, lens_stretch95 : float or None
        95 % limits of the effects of lens errors on a model reconstructed by this program:
        difference of dips between opposite edges, degrees, and relative scale of depths.
    read_north : NorthReference or None
        North reference of the azimuths used, or None if no azimuths are used.
    observations : tuple of ObservationGroup
        Inputs of the adjustment by kind, empty if unknown.
    click_sigma_m : float or None
        Standard deviation of each coordinate of a click on the model, m; None if unknown.
    """

    id: str
    name: str
    method: Method
    frame: Frame = UNDECLARED_FRAME
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
    read_north: NorthReference | None = None
    observations: tuple[ObservationGroup, ...] = ()
    click_sigma_m: float | None = None

    def to_world(self) -> Matrix:
        """Return the 4x4 similarity from the file frame to the World frame."""
        return self.matrix

    def rotation_covariance(self) -> FloatArray | None:
        """Return the covariance (3, 3) of rotations about east, north and up, radians squared.

        The result is None if it is unknown.
        """
        import numpy as np

        if self.covariance is not None:
            return np.array(self.covariance, np.float64)[:3, :3]
        if self.rotation_error_deg is None:
            return None
        up, east, north = np.radians(self.rotation_error_deg)
        return np.diag([east**2, north**2, up**2])

    def shape_covariance(self) -> FloatArray | None:
        """Return the covariance (4, 4) of rotations (radians) and relative scale, or None."""
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
        """Return the RMS positioning error of the model along any direction, one sigma, m.

        The error is averaged over the corners of the bounding box (2, 3) in the World frame, or
        otherwise over check or control points. The result is None if it is unknown.
        """
        import numpy as np

        if self.covariance is not None and self.centre is not None:
            covariance_matrix = np.array(self.covariance, np.float64)
            variance = 0.0
            for is_upper in np.ndindex(2, 2, 2):
                x, y, z = np.where(is_upper, bounds[1], bounds[0]) - self.centre
                # A rotation w moves the corner by w x p, a change of scale along p.
                derivatives = np.hstack(
                    [
                        [[0, z, -y, x], [-z, 0, x, y], [y, -x, 0, z]],
                        np.eye(3),
                    ]
                )
                variance += float(np.trace(derivatives @ covariance_matrix @ derivatives.T))
            return float(np.sqrt(max(variance, 0.0) / 8.0 / 3.0))
        rms = self.rms_check_m or self.rms_control_m
        return None if rms is None else float(rms / np.sqrt(3.0))
