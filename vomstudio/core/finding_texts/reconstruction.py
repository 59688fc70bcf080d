"""Texts of the findings about reconstructions: depths, surfaces, textures and their files."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "reconstruct.not-written": (
        "error",
        to_translate(
            "Results cannot be written ({reason}). Finished results are kept. Free some space and"
            " start again."
        ),
    ),
    "reconstruct.damaged": (
        "error",
        to_translate(
            "A result is incomplete or damaged ({reason}). Remove its folder and start again."
        ),
    ),
    "reconstruct.photo-lost": (
        "error",
        to_translate("This file cannot be read any more ({reason}). Put it back and start again."),
    ),
    "reconstruct.not-yet": (
        "error",
        to_translate("There are no {results} yet. Make the model first."),
    ),
    "reconstruct.photo-not-aligned": (
        "error",
        to_translate("{photo} is not among the aligned photos."),
    ),
    "reconstruct.local-frame": (
        "warning",
        to_translate("The model was not registered and has a local frame without scale. {reason}"),
    ),
    "reconstruct.register-later": (
        "info",
        to_translate(
            "It can be registered later by points, camera positions, compass readings, level lines"
            " and lengths (vomstudio register, or Model > Register by points)."
        ),
    ),
    "reconstruction.finished": (
        "info",
        to_translate(
            "The reconstruction of {name} is finished: {registered} of {photos} photos are"
            " aligned, and the mesh has {faces:,} faces. {fit}"
        ),
    ),
    "reconstruction.memory": (
        "info",
        to_translate("Depth maps and point cloud need up to {needed} of {free} of free memory."),
    ),
    "reconstruction.reduced-depth-maps": (
        "warning",
        to_translate(
            "To fit into it, depth maps are made at {size_px} instead of {wanted_px} pixels."
        ),
    ),
    "reconstruction.aligned": (
        "info",
        to_translate(
            "{registered} of {photos} photos aligned with a mean reprojection error of"
            " {error_px:.2f} px."
        ),
    ),
    "reconstruction.tie-points": (
        "info",
        to_translate(
            "{tie_points:,} tie points, of which {in_three:,} are in three photos or more."
        ),
    ),
    "reconstruction.size": (
        "info",
        to_translate("{points:,} points and {faces:,} triangles in {frame}."),
    ),
    "reconstruction.other-project": (
        "info",
        to_translate("The model belongs to another project: {file}"),
    ),
    "region.not-a-box": (
        "error",
        to_translate("A region is six numbers: x0,y0,z0,x1,y1,z1, its lowest and highest corner."),
    ),
    "region.empty": (
        "error",
        to_translate("The region is empty: x0, y0, z0 must be less than x1, y1, z1."),
    ),
    "region.few-points": (
        "error",
        to_translate(
            "The region contains {points} tie points, too few for two photos. All of them lie in"
            " {bounds}. Check the region and its frame ({frame})."
        ),
    ),
    "region.no-depths": (
        "error",
        to_translate(
            "None of the photos that see the region can have a depth map. Choose a larger region,"
            " or take more photos of it."
        ),
    ),
    "dense.too-few-photos": (
        "error",
        to_translate(
            "Depth maps need two photos of the same rock, but this alignment has only {photos}."
            " Take more photos, or align again."
        ),
    ),
    "dense.few-tie-points": (
        "warning",
        to_translate("{photo} has no depth map: {count} tie point is too few."),
        to_translate("{photo} has no depth map: {count} tie points are too few."),
    ),
    "dense.no-neighbour": (
        "warning",
        to_translate(
            "{photo} has no depth map, since no other photo overlaps it enough with a suitable"
            " base."
        ),
    ),
    "dense.reduced": (
        "warning",
        to_translate(
            "Depth maps have {size_px} instead of {wanted_px} pixels along the long side, since"
            " there is not enough free memory."
        ),
    ),
    "dense.no-sources": (
        "error",
        to_translate("Depths need another photo of the same place."),
    ),
    "dense.no-method": (
        "error",
        to_translate("Each source of the photo needs a method."),
    ),
    "dense.depth-range": (
        "error",
        to_translate(
            "The depth range from {near:g} to {far:g} is invalid. Align the photos again."
        ),
    ),
    "dense.distorted": (
        "error",
        to_translate("The photo must be undistorted first."),
    ),
    "dense.no-base": (
        "error",
        to_translate("{photo} was taken from the same position, so the base is zero."),
    ),
    "dense.map-size": (
        "error",
        to_translate(
            "COLMAP's depth map has {width} x {height} pixels, which is not the size of the photo."
            " Align the photos again."
        ),
    ),
    "dense.no-agreement": (
        "error",
        to_translate(
            "No two depth maps agree anywhere. The photos may be blurred, show a surface without"
            " texture, or be badly aligned."
        ),
    ),
    "dense.calibration": (
        "error",
        to_translate("The calibration of this camera is invalid. Align the photos again."),
    ),
    "gpu.unavailable": (
        "error",
        to_translate(
            "The installed COLMAP cannot use a GPU. Install vomstudio[cuda], or reconstruct with"
            " the device “cpu”."
        ),
    ),
    "gpu.failed": (
        "warning",
        to_translate(
            "The depth maps cannot be computed on the GPU ({reason}). The device “cpu” computes"
            " them without it."
        ),
    ),
    "photo.unreadable": (
        "error",
        to_translate(
            "This photo cannot be decoded. Copy it from the camera again, or leave it out."
        ),
    ),
    "photo.other-size": (
        "error",
        to_translate(
            "This photo has {width} x {height} pixels, but was aligned with {aligned_width} x"
            " {aligned_height}. Align the photos again."
        ),
    ),
    "mask.unreadable": (
        "error",
        to_translate("The mask of this photo cannot be read. Draw it again."),
    ),
    "mask.other-size": (
        "error",
        to_translate(
            "The mask has {mask_width} x {mask_height} pixels, the photo {width} x {height}. Draw"
            " the mask on this photo."
        ),
    ),
    "surface.no-points": (
        "error",
        to_translate("The cloud has no points. A surface needs a dense cloud."),
    ),
    "surface.no-normals": (
        "error",
        to_translate(
            "The cloud has no normals. A surface needs them to know which side is outside."
        ),
    ),
    "surface.few-points": (
        "error",
        to_translate(
            "The cloud has only {points:,} points. A surface needs at least {least}, and some"
            " hundred thousand to be useful."
        ),
    ),
    "surface.coincident-points": (
        "error",
        to_translate("The points of the cloud coincide. A surface needs distinct points."),
    ),
    "surface.nothing-left": (
        "error",
        to_translate(
            "No surface is left near the points. Check that the cloud is dense and its normals are"
            " right."
        ),
    ),
    "surface.not-a-mesh": (
        "error",
        to_translate("The surface is not a valid mesh. Try another octree depth."),
    ),
    "surface.points-left-out": (
        "warning",
        to_translate("{count:,} point without position or normal was left out."),
        to_translate("{count:,} points without position or normal were left out."),
    ),
    "surface.thinned": (
        "warning",
        to_translate("The cloud was thinned from {total:,} to {points:,} points for the surface."),
    ),
    "surface.not-decimated": (
        "warning",
        to_translate(
            "The surface has {faces:,} triangles instead of {wanted:,}, since further decimation"
            " would have broken it."
        ),
    ),
    "texture.no-triangles": (
        "error",
        to_translate("The mesh has no triangles to be textured."),
    ),
    "texture.no-photos": (
        "error",
        to_translate("A texture needs at least one photo."),
    ),
    "texture.no-photo-sees": (
        "error",
        to_translate(
            "No photo sees this mesh. Check that the cameras belong to it and that its triangles"
            " face outwards."
        ),
    ),
    "texture.mostly-unseen": (
        "error",
        to_translate(
            "{share_percent:.0f} % of the surface is in no photo, so most of the model would be"
            " invented. Photograph all sides, or mask all but the rock."
        ),
    ),
    "texture.charts-too-large": (
        "error",
        to_translate("The charts of this surface do not fit on a page. Decimate it first."),
    ),
    "texture.triangle-too-large": (
        "error",
        to_translate("A single triangle is larger than a page. Choose larger pages or texels."),
    ),
    "texture.page-size": (
        "error",
        to_translate("The page size must be 64 to 16384, a multiple of {step}."),
    ),
    "texture.page-too-large": (
        "error",
        to_translate(
            "A texture page of {width} x {height} pixels is too large for JPEG. Choose smaller"
            " pages."
        ),
    ),
    "texture.photo-sees-nothing": (
        "warning",
        to_translate("{photo} sees nothing of the surface."),
    ),
    "texture.larger-pixels": (
        "warning",
        to_translate(
            "Texture pixels are {factor:.3g} times as large as wanted, to fit {count} page."
        ),
        to_translate(
            "Texture pixels are {factor:.3g} times as large as wanted, to fit {count} pages."
        ),
    ),
    "texture.unseen": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the surface is in no photo and has interpolated colours."
        ),
    ),
    "texture.turned-over": (
        "warning",
        to_translate(
            "{count} piece of the surface was turned over, since the photos see its other side."
        ),
        to_translate(
            "{count} pieces of the surface were turned over, since the photos see their other side."
        ),
    ),
    "texture.occluded": (
        "warning",
        to_translate(
            "{photo} was left out over {share_percent:.0f} % of what it sees, since the other"
            " photos show something else there."
        ),
    ),
    "folder.is-file": (
        "error",
        to_translate("This is a file. Name a folder."),
    ),
    "folder.unnamed": (
        "error",
        to_translate("This does not name a folder. Name one."),
    ),
    "folder.not-empty": (
        "error",
        to_translate(
            "The folder contains other files. Name a new or empty folder, or use --force if the"
            " command has it."
        ),
    ),
    "reconstruct.tables-unused": (
        "warning",
        to_translate("The control points are not used. {reason}"),
    ),
    "dense.no-photos": (
        "error",
        to_translate("No two photos share enough tie points for a depth map. {reasons}"),
    ),
}
