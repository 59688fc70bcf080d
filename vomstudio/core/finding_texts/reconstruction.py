"""Texts of the findings about reconstructions: depths, surfaces, textures and their files."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "reconstruct.not-written": (
        "error",
        to_translate(
            "The results cannot be written ({reason}). Finished results are kept. Free some space"
            " and start again."
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
        to_translate("This file can no longer be read ({reason}). Restore it and start again."),
    ),
    "reconstruct.not-yet": (
        "error",
        to_translate("There are no {results} yet. Reconstruct the model first."),
    ),
    "reconstruct.photo-not-aligned": (
        "error",
        to_translate("{photo} is not among the aligned photos."),
    ),
    "reconstruct.local-frame": (
        "warning",
        to_translate(
            "The model is not registered, so it has a local frame without scale. {reason}"
        ),
    ),
    "reconstruct.register-later": (
        "info",
        to_translate(
            "Register it later with points, camera positions, compass readings, level lines or"
            " lengths (vomstudio register, or Model > Register by points)."
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
        to_translate(
            "Depth maps and the point cloud need up to {needed} of memory ({free} available)."
        ),
    ),
    "reconstruction.reduced-depth-maps": (
        "warning",
        to_translate(
            "To fit into memory, depth maps are computed at {size_px} instead of {wanted_px}"
            " pixels."
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
        to_translate("{tie_points:,} tie points, {in_three:,} of them in three or more photos."),
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
        to_translate(
            "A region consists of six numbers, x0,y0,z0,x1,y1,z1: its lowest and its highest"
            " corner."
        ),
    ),
    "region.empty": (
        "error",
        to_translate("The region is empty: x0, y0, z0 must be less than x1, y1, z1."),
    ),
    "region.few-points": (
        "error",
        to_translate(
            "The region contains {points} tie points, too few for two photos. All tie points lie"
            " in {bounds}. Check the region and its frame ({frame})."
        ),
    ),
    "region.no-depths": (
        "error",
        to_translate(
            "No photo that shows the region can have a depth map. Choose a larger region, or take"
            " more photos of it."
        ),
    ),
    "background.left-out": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the tie points are background, over {factor:.1f} times"
            " as far away as the rock. They were left out; Keep background includes them."
        ),
    ),
    "background.kept": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the tie points are background, over {factor:.1f} times"
            " as far away as the rock. They were kept, which reduces the detail of the rock."
        ),
    ),
    "dense.too-few-photos": (
        "error",
        to_translate(
            "Depth maps need two photos of the same rock, but only {photos} are aligned. Take"
            " more photos, or align again."
        ),
    ),
    "dense.few-tie-points": (
        "warning",
        to_translate("{photo} has no depth map, because it has only {count} tie point."),
        to_translate("{photo} has no depth map, because it has only {count} tie points."),
    ),
    "dense.no-neighbour": (
        "warning",
        to_translate(
            "{photo} has no depth map, because no other photo overlaps it enough with a suitable"
            " base."
        ),
    ),
    "dense.reduced": (
        "warning",
        to_translate(
            "Depth maps have {size_px} instead of {wanted_px} pixels along the long side, because"
            " of limited memory."
        ),
    ),
    "dense.no-sources": (
        "error",
        to_translate("Depth maps need another photo of the same rock."),
    ),
    "dense.no-method": (
        "error",
        to_translate("Each source photo needs a method."),
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
            "COLMAP's depth map has {width} x {height} pixels, which differs from the size of the"
            " photo. Align the photos again."
        ),
    ),
    "dense.no-agreement": (
        "error",
        to_translate(
            "No two depth maps agree at any point. The photos may be blurred or badly aligned, or"
            " may show a surface without texture."
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
            "The depth maps cannot be computed on the GPU ({reason}). Use the device “cpu” instead."
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
            "The mask has {mask_width} x {mask_height} pixels, but the photo has {width} x"
            " {height}. Draw the mask on this photo."
        ),
    ),
    "surface.no-points": (
        "error",
        to_translate("The cloud has no points. A surface needs a dense cloud."),
    ),
    "surface.no-normals": (
        "error",
        to_translate(
            "The cloud has no normals, which a surface needs to distinguish inside from outside."
            " Compute them first."
        ),
    ),
    "surface.few-points": (
        "error",
        to_translate(
            "The cloud has only {points:,} points. A surface needs at least {least}, and several"
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
            "No surface remains near the points. Check that the cloud is dense and its normals"
            " are correct."
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
            "The surface has {faces:,} triangles instead of {wanted:,}, because further"
            " decimation would have damaged it."
        ),
    ),
    "texture.no-triangles": (
        "error",
        to_translate("The mesh has no triangles to texture."),
    ),
    "texture.no-photos": (
        "error",
        to_translate("A texture needs at least one photo."),
    ),
    "texture.no-photo-sees": (
        "error",
        to_translate(
            "The mesh is not visible in any photo. Check that the cameras belong to it and that"
            " its triangles face outwards."
        ),
    ),
    "texture.mostly-unseen": (
        "error",
        to_translate(
            "{share_percent:.0f} % of the surface is not visible in any photo, so most of the"
            " texture would be interpolated. Photograph all sides, or mask the surroundings."
        ),
    ),
    "texture.charts-too-large": (
        "error",
        to_translate(
            "The texture charts of this surface do not fit on a page. Decimate the surface first."
        ),
    ),
    "texture.triangle-too-large": (
        "error",
        to_translate(
            "A single triangle is larger than a texture page. Use larger pages or larger texture"
            " pixels."
        ),
    ),
    "texture.page-size": (
        "error",
        to_translate("The page size must be a multiple of {step} from 64 to 16384."),
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
        to_translate("{photo} does not show any part of the surface."),
    ),
    "texture.pages-full": (
        "warning",
        to_translate(
            "On 90 % of the surface, texture pixels cover up to {factor:.2g} photo pixels, because"
            " {count} page is full. Use a higher quality or a region."
        ),
        to_translate(
            "On 90 % of the surface, texture pixels cover up to {factor:.2g} photo pixels, because"
            " {count} pages are full. Use a higher quality or a region."
        ),
    ),
    "texture.coarse": (
        "warning",
        to_translate(
            "On 90 % of the surface, texture pixels cover up to {factor:.2g} photo pixels, more"
            " than {limit:g}, because many faces are steep."
        ),
    ),
    "texture.unseen": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the surface is not visible in any photo and has interpolated"
            " colours."
        ),
    ),
    "texture.turned-over": (
        "warning",
        to_translate(
            "{count} part of the surface was flipped, because the photos show its other side."
        ),
        to_translate(
            "{count} parts of the surface were flipped, because the photos show their other side."
        ),
    ),
    "texture.occluded": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the view of {photo} was not used, because the other photos"
            " show something else there."
        ),
    ),
    "folder.is-file": (
        "error",
        to_translate("This is a file. Specify a folder."),
    ),
    "folder.unnamed": (
        "error",
        to_translate("The folder has no name. Specify one."),
    ),
    "folder.not-empty": (
        "error",
        to_translate(
            "The folder contains other files. Specify a new or empty folder, or use --force if"
            " the command supports it."
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
