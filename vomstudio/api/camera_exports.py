"""Cameras of reconstructions for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.api.checking import check_flag, name_argument_in_errors, to_path

if TYPE_CHECKING:
    from vomstudio.api.argument_types import PathArgument
    from vomstudio.photogrammetry.inspect.camera_export import CameraExport


def export_cameras(
    source: PathArgument, target: PathArgument, *, world: bool = False, force: bool = False
) -> CameraExport:
    """Write cameras and tie points for COLMAP or nerfstudio.

    Parameters
    ----------
    source : str or Path
        Folder of a reconstruction, or a camera file of any supported program.
    target : str or Path
        ``transforms.json`` (or another ``NAME.json``) for nerfstudio, otherwise a folder for the
        text files of COLMAP.
    world : bool, optional
        Whether to write World coordinates, metres. By default, coordinates are relative to the
        origin of the cameras, which keeps them small.
    force : bool, optional
        Whether to replace existing files.

    Returns
    -------
    CameraExport
        ``files``, ``photos``, ``points``, ``frame`` ("world" or "local"), ``crs``, ``origin``,
        ``warnings``.

    Raises
    ------
    vs.errors.InputError
        If the cameras cannot be read.
    vs.errors.UsageError
        If World coordinates are requested for cameras that are not registered.
    vs.errors.TargetError
        If a file exists or cannot be written.

    Notes
    -----
    The files follow the documentation of COLMAP ("Output Format") and nerfstudio ("Data
    conventions").

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import vomstudio as vs
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "bundle.out").write_text(
    ...     "# Bundle file v0.3" + chr(10) + "1 0" + chr(10) + "900 0 0" + chr(10)
    ...     + chr(10).join(["1 0 0", "0 1 0", "0 0 1", "0 0 0"]) + chr(10))
    >>> _ = (folder / "list.txt").write_text("a.jpg")
    >>> export = vs.export_cameras(folder / "bundle.out", folder / "colmap")
    >>> export.photos, export.frame, (folder / "colmap" / "images.txt").is_file()
    (1, 'local', True)
    """
    from vomstudio.photogrammetry.inspect import camera_export

    world, force = check_flag(world, "world"), check_flag(force, "force")
    with name_argument_in_errors("world", "--world"):
        return camera_export.export_cameras(
            to_path(source, "source"), to_path(target, "target"), world=world, force=force
        )
