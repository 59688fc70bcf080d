"""The frame of a model: what its file states, completed by options."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame, UpAxis
from vomstudio.geometry.matrices import IDENTITY, Matrix
from vomstudio.geometry.registration_frames import change_file_frame, change_world
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import METRES
from vomstudio.io.gate.axes import assumed_frame, choose_axes
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.metric import check_metric, degrees_finding
from vomstudio.io.gate.reprojection import Reprojection
from vomstudio.io.gis.crs import parse_crs_option, unit_in_metres
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.registration_file import (
    FoundRegistration,
    find_registration,
    registration_path,
)
from vomstudio.io.photos.cameras_file import scale_known


@dataclass(frozen=True)
class FrameWithFindings:
    """A frame, and what was assumed to establish it.

    Parameters
    ----------
    frame : Frame
    findings : tuple of Finding
    registration : Registration, optional
        The measured one that the frame is that of; None for a stated or assumed frame.
    """

    frame: Frame
    findings: tuple[Finding, ...] = ()
    registration: Registration | None = None

    @property
    def placement(self) -> Frame | Registration:
        """The registration, else the frame."""
        return self.registration or self.frame

    def to_world(self) -> Matrix:
        """4x4 similarity from the file to World."""
        return self.placement.to_world()


def establish_frame(
    loaded: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> FrameWithFindings:
    """Establish the frame of a model that was read with the same options.

    A file that states nothing is taken as local, in metres, z up. A registration beside the file
    (`find_registration`) places it, unless the options or the file state another frame.

    Parameters
    ----------
    loaded : LoadedModel
        From `vomstudio.io.models.opening.read_model`.
    options : FrameOptions

    Returns
    -------
    FrameWithFindings
        With ``frame.assumed`` if neither file nor options define up axis and unit.

    Raises
    ------
    InputError
        With the code ``frame.not-metric`` for a CRS that is not metric at the data.
    UsageError
        For options that contradict the file's format or each other.
    """
    field = "--to-crs" if options.to_crs else "--crs" if options.crs else "CRS"
    bounds = np.asarray(loaded.data.bounds, np.float64)
    found = stored_registration(loaded, options)
    registration = found.registration
    if registration is not None:
        placed = bounds_in_world(bounds, registration.matrix)
        findings = check_frame(registration.frame, placed, file=loaded.path, field=field)
        return FrameWithFindings(registration.frame, findings, registration)
    frame = _frame(loaded, options)
    if frame.crs is None:
        findings = _assumed(loaded, options, frame.up_axis)
    else:
        findings = check_frame(frame, bounds, file=loaded.path, field=field)
    return FrameWithFindings(frame, (*found.findings, *findings))


def stored_registration(
    loaded: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> FoundRegistration:
    """Find the registration beside a model that was read with the same options.

    Parameters
    ----------
    loaded : LoadedModel
    options : FrameOptions
        With ``to_crs`` the registration is converted as the coordinates were.

    Returns
    -------
    FoundRegistration
        None, with ``registration.other-frame``, if the options or the file state another frame.
        A registration without errors (photos without scale) counts as none.
    """
    stated = None
    # With `to_crs` what the file states was converted when it was read.
    if options.to_crs is None:
        stated = loaded.crs if options.crs is None else parse_crs_option(options.crs)[0]
    found = registration_beside(loaded.path, loaded.content_hash, stated)
    registration = found.registration
    if registration is None:
        return found
    if options.to_crs is not None:
        crs = registration.frame.crs
        if crs is not None and _is_in_world(registration):
            return FoundRegistration(_reprojected(registration, crs, loaded))
        return _not_used(loaded.path, registration, options.to_crs)
    if options.up == "y" and loaded.turned_about is None:
        return _not_used(loaded.path, registration, "--up y")
    if options.unit is not None and METRES[options.unit] != 1.0:
        return _not_used(loaded.path, registration, options.unit)
    return found


def registration_beside(path: Path, content_hash: str, stated: str | None) -> FoundRegistration:
    """Find the registration beside a model, and compare its CRS with that of the file.

    Parameters
    ----------
    path : Path
    content_hash : str
        SHA-256 of the model's file.
    stated : str, optional
        CRS that the file states.
    """
    found = find_registration(path, content_hash)
    registration = found.registration
    if registration is None or registration.rotation_covariance() is None:
        return FoundRegistration(None, found.findings)
    frame = registration.frame
    if stated is None or (frame.crs is not None and _is_same_crs(stated, frame.crs)):
        return found
    if frame.kind == "local" and _is_in_world(registration) and unit_in_metres(stated) == 1.0:
        # The CRS was stated later: the local frame has become that of a map.
        return FoundRegistration(replace(registration, frame=Frame("crs", stated)))
    return _not_used(path, registration, stated)


def _is_in_world(registration: Registration) -> bool:
    """Whether the coordinates of the file are those of World."""
    return registration.matrix == IDENTITY


def _not_used(model: Path, registration: Registration, stated: str) -> FoundRegistration:
    file = registration_path(model).name
    crs = registration.frame.crs or registration.frame.name()
    finding = Finding("registration.other-frame", file=file, crs=crs, stated=stated)
    return FoundRegistration(None, (finding,))


def _is_same_crs(first: str, second: str) -> bool:
    if first == second:
        return True
    from pyproj import CRS

    return CRS.from_user_input(first).equals(CRS.from_user_input(second), ignore_axis_order=True)


def _reprojected(registration: Registration, crs: str, loaded: LoadedModel) -> Registration:
    """Return the registration of a model whose coordinates were converted from `crs`."""
    assert loaded.crs is not None
    conversion = Reprojection.create(crs, loaded.crs)
    if registration.centre is not None:
        centre = np.array(registration.centre)
    else:
        middle = np.asarray(loaded.data.bounds, np.float64).mean(axis=0)
        centre = Reprojection.create(loaded.crs, crs).apply(middle[None])[0]
    left, sizes, right = np.linalg.svd(conversion.jacobian(centre))
    by = np.eye(4)
    by[:3, :3] = np.cbrt(sizes.prod()) * left @ right
    by[:3, 3] = conversion.apply(centre[None])[0] - by[:3, :3] @ centre
    moved = change_world(registration, by, Frame("crs", loaded.crs))
    # The coordinates of the file were converted too.
    return change_file_frame(moved, moved.matrix)


def bounds_in_world(bounds: FloatArray, to_world: Matrix) -> FloatArray:
    """Return lowest and highest corner, (2, 3), of a box of the file's frame in World."""
    corners = np.array([[bounds[k, j] for j, k in enumerate(each)] for each in np.ndindex(2, 2, 2)])
    placed = transform.apply(to_world, corners)
    return np.array([placed.min(axis=0), placed.max(axis=0)])


def check_frame(
    frame: Frame,
    bounds: FloatArray,
    *,
    file: str | Path | None = None,
    field: str = "CRS",
) -> tuple[Finding, ...]:
    """Check that a frame is metric at the data.

    Parameters
    ----------
    frame : Frame
    bounds : (2, 3) float
        Lowest and highest corner in the file's frame.
    file, field : optional
        For the error.

    Returns
    -------
    tuple of Finding
        Empty for a frame without a CRS.

    Raises
    ------
    InputError
        With the code ``frame.not-metric``.
    """
    if frame.crs is None:
        return ()
    return check_metric(frame.crs, _map_bounds(bounds, frame), file=file, field=field)


def frame_findings(
    loaded: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> tuple[Finding, ...]:
    """Return what `establish_frame` reports or would refuse."""
    try:
        return establish_frame(loaded, options).findings
    except InputError as error:
        if not error.code.startswith("frame."):
            raise
        return (Finding(error.code, **error.values),)


def _frame(loaded: LoadedModel, options: FrameOptions) -> Frame:
    if options.to_crs is not None:
        # The coordinates were converted when they were read.
        return Frame("crs", loaded.crs, 1.0, "z")
    up = _up_axis(loaded, options)
    axes, _ = choose_axes(loaded.crs, options, file=loaded.path)
    if axes.crs is not None:
        return Frame("crs", axes.crs, axes.metres[0], up)
    if options.unit is None and scale_known(loaded.path) is False:
        return Frame(up_axis=up)
    unit_m = METRES[options.unit] if options.unit is not None else loaded.unit_m or 1.0
    return Frame("local", None, unit_m, up)


def _map_bounds(bounds: FloatArray, frame: Frame) -> FloatArray:
    """Return lowest and highest east and north in the unit of the CRS, (2, 2)."""
    low, high = bounds
    if frame.up_axis == "y":
        # The file's z is South.
        return np.array([[low[0], -high[2]], [high[0], -low[2]]])
    return np.array([low[:2], high[:2]])


def frame_of_file(path: Path, crs: str | None) -> Frame:
    """Return the frame that a file states, undeclared if it states none.

    A model reconstructed with control points in a local system is in metres and knows north.
    """
    if crs:
        return Frame("crs", crs, unit_in_metres(crs))
    return Frame("local") if scale_known(path) else Frame()


def _up_axis(loaded: LoadedModel, options: FrameOptions) -> UpAxis:
    if loaded.turned_about is None:
        return options.up or "z"
    if options.up == "z":
        raise UsageError(Finding("frame.up-by-format"), field="--up")
    return "z"


def _assumed(loaded: LoadedModel, options: FrameOptions, up: UpAxis) -> tuple[Finding, ...]:
    """Return the findings about a file without a CRS."""
    if scale_known(loaded.path) is not None:
        # Our own reconstruction states what it knows in the file beside it.
        return ()
    maybe = degrees_finding(np.asarray(loaded.data.bounds, np.float64))
    findings = () if maybe is None or options.unit is not None else (maybe,)
    assumed = assumed_frame(
        loaded.path,
        options,
        up=up,
        unit=options.unit or (loaded.units[0] if loaded.unit_m is not None else "m"),
        has_up=loaded.turned_about is not None,
        has_unit=loaded.unit_m is not None,
    )
    return (*assumed, *findings)
