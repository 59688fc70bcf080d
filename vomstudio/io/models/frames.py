"""Frame of a model: the statements of its file, complemented by options."""

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
from vomstudio.geometry.registration_frames import change_file_frame, change_world_frame
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.axes import assumed_frame_findings, choose_axes
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.metric import check_metric, degrees_finding
from vomstudio.io.gate.reprojection import Reprojection
from vomstudio.io.gis.crs import parse_crs_option, unit_in_metres
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.registration_file import (
    SidecarRegistration,
    find_registration,
    registration_path,
)
from vomstudio.io.photos.cameras_file import has_known_scale


@dataclass(frozen=True)
class FrameWithFindings:
    """Frame with the findings about its assumptions.

    Parameters
    ----------
    frame : Frame
    findings : tuple of Finding
    registration : Registration, optional
        Measured registration that defines the frame; None for a stated or assumed frame.
    """

    frame: Frame
    findings: tuple[Finding, ...] = ()
    registration: Registration | None = None

    @property
    def placement(self) -> Frame | Registration:
        """Registration, or the frame if there is no registration."""
        return self.registration or self.frame

    def to_world(self) -> Matrix:
        """Return the similarity transformation (4, 4) from the file frame to the World frame."""
        return self.placement.to_world()


def establish_frame(
    loaded_model: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> FrameWithFindings:
    """Determine the frame of a model that was read with the same options.

    A file that states nothing is assumed to be local, in metres, with z up; a model that was
    reconstructed without scale has an undeclared frame. A registration next to the file
    (`find_registration`) determines its placement unless the options or the file state another
    frame.

    Parameters
    ----------
    loaded_model : LoadedModel
        Model returned by `vomstudio.io.models.opening.read_model`.
    options : FrameOptions

    Returns
    -------
    FrameWithFindings
        Frame, with ``frame.assumed`` if neither file nor options define the up axis or the unit.

    Raises
    ------
    InputError
        With the code ``frame.not-metric`` if the CRS is not metric at the data.
    UsageError
        If options contradict the format of the file or each other.
    """
    field = "--to-crs" if options.to_crs else "--crs" if options.crs else "CRS"
    bounds = np.asarray(loaded_model.data.bounds, np.float64)
    sidecar = stored_registration(loaded_model, options)
    registration = sidecar.registration
    if registration is not None:
        placed_bounds = world_bounds(bounds, registration.matrix)
        findings = check_frame(
            registration.frame, placed_bounds, file=loaded_model.path, field=field
        )
        return FrameWithFindings(registration.frame, findings, registration)
    frame = _frame(loaded_model, options)
    if frame.crs is None:
        findings = _assumption_findings(loaded_model, options, frame.up_axis)
    else:
        findings = check_frame(frame, bounds, file=loaded_model.path, field=field)
    return FrameWithFindings(frame, (*sidecar.findings, *findings))


def stored_registration(
    loaded_model: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> SidecarRegistration:
    """Find the registration next to a model that was read with the same options.

    Parameters
    ----------
    loaded_model : LoadedModel
    options : FrameOptions
        Frame options; with ``to_crs``, the registration is converted in the same way as the
        coordinates.

    Returns
    -------
    SidecarRegistration
        Contains no registration but ``registration.other-frame`` if the options or the file state
        another frame. A registration without errors (photos without scale) is ignored.
    """
    stated_crs = None
    # With `to_crs`, the CRS of the file was already converted when the file was read.
    if options.to_crs is None:
        stated_crs = loaded_model.crs if options.crs is None else parse_crs_option(options.crs)[0]
    sidecar = find_matching_registration(loaded_model.path, loaded_model.content_hash, stated_crs)
    registration = sidecar.registration
    if registration is None:
        return sidecar
    if options.to_crs is not None:
        crs = registration.frame.crs
        if crs is not None and _is_in_world(registration):
            return SidecarRegistration(_reproject_registration(registration, crs, loaded_model))
        return _unused_registration(loaded_model.path, registration, options.to_crs)
    if options.up == "y" and loaded_model.turned_about is None:
        return _unused_registration(loaded_model.path, registration, "--up y")
    if options.unit is not None and METRES_PER_UNIT[options.unit] != 1.0:
        return _unused_registration(loaded_model.path, registration, options.unit)
    return sidecar


def find_matching_registration(
    path: Path, content_hash: str, stated_crs: str | None
) -> SidecarRegistration:
    """Find the registration next to a model and compare its CRS with that of the file.

    If the CRSs differ, ``registration.other-frame`` is returned instead of the registration. A
    registration without errors is ignored. If the file contains local World coordinates, the
    registration adopts its CRS, provided that this is in metres.

    Parameters
    ----------
    path : Path
    content_hash : str
        SHA-256 of the model file.
    stated_crs : str or None
        CRS stated by the file.
    """
    sidecar = find_registration(path, content_hash)
    registration = sidecar.registration
    if registration is None or registration.rotation_covariance() is None:
        return SidecarRegistration(None, sidecar.findings)
    frame = registration.frame
    if stated_crs is None or (frame.crs is not None and _is_same_crs(stated_crs, frame.crs)):
        return sidecar
    if frame.kind == "local" and _is_in_world(registration) and unit_in_metres(stated_crs) == 1.0:
        # The CRS was stated later: the local frame is now that of the map.
        return SidecarRegistration(replace(registration, frame=Frame("crs", stated_crs)))
    return _unused_registration(path, registration, stated_crs)


def _is_in_world(registration: Registration) -> bool:
    """Return whether the file coordinates are World coordinates."""
    return registration.matrix == IDENTITY


def _unused_registration(
    model: Path, registration: Registration, stated_crs: str
) -> SidecarRegistration:
    file = registration_path(model).name
    crs = registration.frame.crs or registration.frame.name()
    finding = Finding("registration.other-frame", file=file, crs=crs, stated=stated_crs)
    return SidecarRegistration(None, (finding,))


def _is_same_crs(crs: str, other_crs: str) -> bool:
    if crs == other_crs:
        return True
    from pyproj import CRS

    return CRS.from_user_input(crs).equals(CRS.from_user_input(other_crs), ignore_axis_order=True)


def _reproject_registration(
    registration: Registration, crs: str, loaded_model: LoadedModel
) -> Registration:
    """Return the registration of a model whose coordinates were converted from `crs`."""
    assert loaded_model.crs is not None
    reprojection = Reprojection.create(crs, loaded_model.crs)
    if registration.centre is not None:
        centre = np.array(registration.centre)
    else:
        midpoint = np.asarray(loaded_model.data.bounds, np.float64).mean(axis=0)
        centre = Reprojection.create(loaded_model.crs, crs).apply(midpoint[None])[0]
    left_vectors, singular_values, right_vectors = np.linalg.svd(reprojection.jacobian(centre))
    transformation = np.eye(4)
    transformation[:3, :3] = np.cbrt(singular_values.prod()) * left_vectors @ right_vectors
    transformation[:3, 3] = reprojection.apply(centre[None])[0] - transformation[:3, :3] @ centre
    converted_registration = change_world_frame(
        registration, transformation, Frame("crs", loaded_model.crs)
    )
    # The coordinates of the file were converted as well.
    return change_file_frame(converted_registration, converted_registration.matrix)


def world_bounds(bounds: FloatArray, to_world: Matrix) -> FloatArray:
    """Return the World bounds (2, 3) of a box in the file frame."""
    corners = np.array(
        [[bounds[k, j] for j, k in enumerate(indices)] for indices in np.ndindex(2, 2, 2)]
    )
    points = transform.apply(to_world, corners)
    return np.array([points.min(axis=0), points.max(axis=0)])


def check_frame(
    frame: Frame,
    bounds: FloatArray,
    *,
    file: str | Path | None = None,
    field: str = "CRS",
) -> tuple[Finding, ...]:
    """Check that a frame is metric at the location of the data.

    Parameters
    ----------
    frame : Frame
    bounds : (2, 3) float
        Lower-left and upper-right corners in the file frame.
    file, field : optional
        File, and option or column of the CRS, for error messages.

    Returns
    -------
    tuple of Finding
        Findings; empty for a frame without a CRS.

    Raises
    ------
    InputError
        As for `check_metric`.
    """
    if frame.crs is None:
        return ()
    return check_metric(frame.crs, _map_bounds(bounds, frame), file=file, field=field)


def frame_findings(
    loaded_model: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> tuple[Finding, ...]:
    """Return the findings that `establish_frame` reports or raises as errors."""
    try:
        return establish_frame(loaded_model, options).findings
    except InputError as error:
        if not error.code.startswith("frame."):
            raise
        return (Finding(error.code, **error.values),)


def _frame(loaded_model: LoadedModel, options: FrameOptions) -> Frame:
    if options.to_crs is not None:
        # The coordinates were already converted when the file was read.
        return Frame("crs", loaded_model.crs, 1.0, "z")
    up = _up_axis(loaded_model, options)
    axes, _ = choose_axes(loaded_model.crs, options, file=loaded_model.path)
    if axes.crs is not None:
        return Frame("crs", axes.crs, axes.metres[0], up)
    if options.unit is None and has_known_scale(loaded_model.path) is False:
        return Frame(up_axis=up)
    unit_m = (
        METRES_PER_UNIT[options.unit] if options.unit is not None else loaded_model.unit_m or 1.0
    )
    return Frame("local", None, unit_m, up)


def _map_bounds(bounds: FloatArray, frame: Frame) -> FloatArray:
    """Return the minimum and maximum east and north in the unit of the CRS, (2, 2)."""
    low, high = bounds
    if frame.up_axis == "y":
        # The z axis of the file points south.
        return np.array([[low[0], -high[2]], [high[0], -low[2]]])
    return np.array([low[:2], high[:2]])


def file_frame(path: Path, crs: str | None) -> Frame:
    """Return the frame stated by a file; it is undeclared if the file states none.

    A model that was reconstructed with control points in a local system is in metres and has a
    north reference.
    """
    if crs:
        return Frame("crs", crs, unit_in_metres(crs))
    return Frame("local") if has_known_scale(path) else Frame()


def _up_axis(loaded_model: LoadedModel, options: FrameOptions) -> UpAxis:
    if loaded_model.turned_about is None:
        return options.up or "z"
    if options.up == "z":
        raise UsageError(Finding("frame.up-by-format"), field="--up")
    return "z"


def _assumption_findings(
    loaded_model: LoadedModel, options: FrameOptions, up: UpAxis
) -> tuple[Finding, ...]:
    """Return the findings about a file that has no CRS."""
    if has_known_scale(loaded_model.path) is not None:
        # A reconstruction by this program stores its known properties in the file next to the
        # model.
        return ()
    degrees_warning = degrees_finding(np.asarray(loaded_model.data.bounds, np.float64))
    findings = () if degrees_warning is None or options.unit is not None else (degrees_warning,)
    assumption_findings = assumed_frame_findings(
        loaded_model.path,
        options,
        up=up,
        unit=options.unit or (loaded_model.units[0] if loaded_model.unit_m is not None else "m"),
        has_up=loaded_model.turned_about is not None,
        has_unit=loaded_model.unit_m is not None,
    )
    return (*assumption_findings, *findings)
