"""Texts of the findings about models, fields and other states of an open project."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "display.no-textures": (
        "info",
        to_translate("No open model has a texture."),
    ),
    "display.no-colours": (
        "info",
        to_translate("No open model has its own colours."),
    ),
    "display.cloud-without-faces": (
        "info",
        to_translate("A point cloud has no triangles."),
    ),
    "display.cloud-not-lit": (
        "info",
        to_translate("A point cloud has no surface to light. Eye-dome lighting shows its shape."),
    ),
    "display.no-cloud": (
        "info",
        to_translate("Eye-dome lighting needs a point cloud. Use lighting for a mesh."),
    ),
    "drawing.orthophoto-of-other-file": (
        "warning",
        to_translate(
            "The orthophoto was made from a file other than {model}, or before this file changed."
            " Create the orthophoto again."
        ),
    ),
    "picks.none-usable": (
        "error",
        to_translate("None of the groups of points ({count}) can be added. {first}"),
    ),
    "picks.no-plane": (
        "error",
        to_translate("None of the picked lines ({count}) defines a plane. {first}"),
    ),
    "model.already-added": (
        "warning",
        to_translate("The project already contains this file, as {model}."),
    ),
    "model.already-open": (
        "info",
        to_translate("{file} is already open."),
    ),
    "model.converted": (
        "info",
        to_translate("{file} was converted to {crs}. The project uses the copy."),
    ),
    "model.copied": (
        "info",
        to_translate("{model} was copied into the project folder."),
    ),
    "model.cloud-too-large": (
        "error",
        to_translate(
            "{model} is too large to be loaded completely. Raise the point limit in the settings,"
            " or cut out a part."
        ),
    ),
    "model.fields-too-large": (
        "error",
        to_translate("The model is too large to show its fields. Cut out a part."),
    ),
    "model.placed-anew": (
        "warning",
        to_translate(
            "The position of the model has changed, so earlier proposals are not valid. Search"
            " again."
        ),
    ),
    "cache.unreadable": (
        "error",
        to_translate("The results could not be read from the cache. Compute them again."),
    ),
    "job.stopped": (
        "info",
        to_translate("Stopped. Nothing was changed."),
    ),
    "field.feature-missing": (
        "error",
        to_translate("The feature or model that this field refers to is no longer in the project."),
    ),
    "field.no-plane": (
        "error",
        to_translate("The selected feature has no plane with a position. Select another one."),
    ),
    "grid.no-model": (
        "warning",
        to_translate("The model of {grid} is no longer in the project."),
    ),
    "selection.no-slip": (
        "error",
        to_translate("Select a slip lineation on a fault first."),
    ),
    "selection.not-two-planes": (
        "error",
        to_translate("Select two planes first."),
    ),
    "selection.no-feature-read": (
        "error",
        to_translate("Select the trace, patch or line that was measured with a compass."),
    ),
    "slip.across-plane": (
        "error",
        to_translate(
            "The lineation is perpendicular to its plane, so it cannot be a slip direction."
            " Select another one."
        ),
    ),
    "feature.not-on-model": (
        "error",
        to_translate("{feature} is not on a model. Select a trace, patch or line on the model."),
    ),
    "feature.no-attitude": (
        "error",
        to_translate(
            "{feature} has no plane or direction to compare with a reading. Select another feature."
        ),
    ),
    "feature.same-names": (
        "warning",
        to_translate(
            "{count} name is used by more than one feature: {names}. Tables distinguish them only"
            " by id. Rename one with F2."
        ),
        to_translate(
            "{count} names are used by more than one feature: {names}. Tables distinguish them"
            " only by id. Rename some with F2."
        ),
    ),
    "registration.few-marked-points": (
        "error",
        to_translate(
            "At least three points are required, each marked in at least two photos. Mark more"
            " points."
        ),
    ),
    "scale.check-bar": (
        "warning",
        to_translate(
            "Check scale bar {name}: its length in the registered model is wrong by"
            " {error_m:+.3g} m."
        ),
    ),
    "project.saved": (
        "info",
        to_translate("{project} was saved."),
    ),
    "project.saved-as": (
        "info",
        to_translate("The project was saved as {folder}."),
    ),
    "project.home-not-writable": (
        "warning",
        to_translate(
            "Your home folder is not writable: settings are not saved, and unsaved work is in"
            " {folder}, which the system may empty. Save the project elsewhere."
        ),
    ),
    "project.opening": (
        "warning",
        to_translate("Another project is being opened. Please wait."),
    ),
    "project.on-disk-again": (
        "warning",
        to_translate("Saving works again. All steps are on disk."),
    ),
    "project.closed": ("error", to_translate("The project is closed. Open it again.")),
    "project.recovered-and-saved": (
        "warning",
        to_translate("Unsaved changes of an earlier session were recovered and saved."),
    ),
    "project.recovered": (
        "warning",
        to_translate("Unsaved work was restored. Save it, or discard it with Undo."),
    ),
    "surroundings.unknown": (
        "warning",
        to_translate("Resolution and outcrop face are unknown for the new planes."),
    ),
    "surroundings.running": (
        "info",
        to_translate("The surroundings are being measured. Please wait."),
    ),
    "surroundings.models-closed": (
        "error",
        to_translate("The models of these features are not open. Locate their files first."),
    ),
    "surroundings.earlier-rule": (
        "info",
        to_translate(
            "The resolution and outcrop face of {count} feature were measured with an earlier"
            " method. Use Interpret > Update earlier features to measure them again."
        ),
        to_translate(
            "The resolution and outcrop face of {count} features were measured with an earlier"
            " method. Use Interpret > Update earlier features to measure them again."
        ),
    ),
    "surroundings.updated": (
        "info",
        to_translate(
            "The surroundings of {count} feature were measured again. Undo restores the "
            "earlier values."
        ),
        to_translate(
            "The surroundings of {count} features were measured again. Undo restores the "
            "earlier values."
        ),
    ),
    "surroundings.left-out": (
        "warning",
        to_translate("{count} feature keeps its earlier values, because its model is not open."),
        to_translate(
            "{count} features keep their earlier values, because their models are not open."
        ),
    ),
    "model.not-cached": (
        "error",
        to_translate("The file could not be cached. {reason}"),
    ),
    "feature.left-out": (
        "warning",
        to_translate("{feature} was left out: {reason}"),
    ),
    "features.several-selected": (
        "info",
        to_translate(
            "{n} features are selected, and changes apply to all of them. The values shown are"
            " those of {name}."
        ),
    ),
    "field.not-calculated": ("info", to_translate("{field} is missing. Compute it again.")),
    "features.no-orientation": (
        "info",
        to_translate("None of these features has an orientation. Choose other features."),
    ),
    "features.left-out": (
        "warning",
        to_translate("{count} features were left out: {reason}"),
    ),
    "features.added": (
        "info",
        *to_translate_n(
            "Added {count} feature.",
            "Added {count} features.",
        ),
    ),
    "photo.left-out": (
        "warning",
        to_translate("{photo} was left out: {reason}"),
    ),
    "project.layers-outdated": (
        "warning",
        to_translate("The GIS layers are not up to date. {reason}"),
    ),
    "project.parts-left-out": (
        "warning",
        to_translate(
            "{count} part of the project could not be read and was left out. The first: {first}"
        ),
        to_translate(
            "{count} parts of the project could not be read and were left out. The first: {first}"
        ),
    ),
    "registration.marks-unused": (
        "error",
        to_translate("The registration failed, and some marks were not used. {marks} {reason}"),
    ),
    "grid.no-points": (
        "error",
        to_translate("The model has no points to cover with a grid. Choose a model with points."),
    ),
    "grid.too-many-cells": (
        "error",
        to_translate(
            "The grid would have more than {maximum:,} cells. Enter a cell size of at least"
            " {minimum:.2g}."
        ),
    ),
    "grid.unmeasurable-cells": (
        "info",
        *to_translate_n(
            "{count} unmeasurable cell is excluded from the counts per area ({share_percent:.0f}"
            " % of the face).",
            "{count} unmeasurable cells are excluded from the counts per area"
            " ({share_percent:.0f} % of the face).",
        ),
    ),
    "grid.open-cells": (
        "info",
        *to_translate_n(
            "{count} cell that was not inspected is also excluded ({share_percent:.0f} %).",
            "{count} cells that were not inspected are also excluded ({share_percent:.0f} %).",
        ),
    ),
    "grid.empty-cells-with-features": (
        "warning",
        to_translate(
            "These cells are marked as empty but contain features: {cells}. Correct the marks."
        ),
    ),
    "filter.unknown-column": (
        "error",
        to_translate(
            "“{name}” is not a column. The tooltip lists all columns. Put a word that contains"
            " : in quotes."
        ),
    ),
    "filter.similar-column": (
        "error",
        to_translate(
            "“{name}” is not a column. Did you mean {similar}? The tooltip lists all columns."
            " Put a word that contains : in quotes."
        ),
    ),
    "filter.needs-word": (
        "error",
        to_translate("“{condition}” is incomplete. Add a word, such as {name}:{example}."),
    ),
    "filter.needs-yes-or-no": (
        "error",
        to_translate("“{condition}” is not valid. Write {name}:yes or {name}:no."),
    ),
    "filter.needs-number": (
        "error",
        to_translate(
            "“{condition}” is not valid. Write a number, such as {name}>30 or {name}:20..45."
        ),
    ),
    "filter.text-has-no-size": (
        "error",
        to_translate("“{condition}” compares text with < or >. Use : (contains) or = (equals)."),
    ),
    "view.damaged": (
        "warning",
        to_translate("The view “{name}” is damaged and cannot be shown. Delete it."),
    ),
    "cameras.not-shown": (
        "warning",
        to_translate("The cameras of {model} cannot be shown. {reason}"),
    ),
    "display.crossed-limits": (
        "warning",
        to_translate("The lower limit must be below the upper one. The range is unchanged."),
    ),
    "model.far-away": (
        "warning",
        to_translate(
            "{model} is {distance:.3g} {unit} away from the other models. Check its frame. "
            "Whole model (Home) shows all of them."
        ),
    ),
    "frame.of-project": (
        "info",
        to_translate("The file specifies no CRS, so the CRS of the project ({crs}) is used."),
    ),
    "frame.undeclared": (
        "warning",
        *to_translate_n(
            "The frame of {count} more model is not declared. Choose it in the project "
            "tree, then Model > Declare frame.",
            "The frames of {count} more models are not declared. Choose each in the project "
            "tree, then Model > Declare frame.",
        ),
    ),
    "model.placed": (
        "info",
        to_translate("Registration of {model}: {facts}."),
    ),
    "model.moved": (
        "warning",
        to_translate("The model was moved or removed in the meantime. Import the file again."),
    ),
    "drawing.cancelled": (
        "info",
        to_translate("The drawing was not imported."),
    ),
    "file.unchanged": (
        "warning",
        to_translate("{reason} The file was not changed."),
    ),
    "file.reading": (
        "info",
        to_translate("Reading {file}…"),
    ),
    "delete.hidden-left": (
        "info",
        *to_translate_n(
            "{count} selected feature was not deleted, because the list filter hides it.",
            "{count} selected features were not deleted, because the list filter hides them.",
        ),
    ),
    "delete.hidden-deleted": (
        "info",
        *to_translate_n(
            "{count} deleted feature was hidden by a filter in the list. Undo restores it.",
            "{count} deleted features were hidden by a filter in the list. Undo restores them.",
        ),
    ),
    "photo.busy": (
        "warning",
        to_translate("The photo cannot be closed yet. {reason}"),
    ),
    "planes.none": (
        "error",
        to_translate("No planes have been measured yet. Measure some on the outcrop."),
    ),
    "selection.no-line": (
        "error",
        to_translate("Select a lineation or an intersection first."),
    ),
    "selection.no-patch": (
        "error",
        to_translate("Select a plane that was grown or painted first."),
    ),
    "selection.unsuitable": (
        "info",
        to_translate(
            "The selection contains no suitable features. Select others, or choose a group above."
        ),
    ),
    "selection.no-plane": (
        "error",
        to_translate("Select one plane first."),
    ),
    "net.copied": (
        "info",
        to_translate("The stereonet has been copied to the clipboard."),
    ),
    "net.no-preview": (
        "info",
        to_translate("A preview shows at most {maximum:,} orientations."),
    ),
    "net.only": (
        "info",
        to_translate("{what}: only available on a net. Choose a net as the view."),
    ),
    "selection.no-trace-or-patch": (
        "error",
        to_translate("Select a trace or patch to use its plane."),
    ),
    "field.plane-missing": (
        "error",
        to_translate("Enter the plane as dip direction and dip, such as 315/38."),
    ),
    "model.no-other": (
        "error",
        to_translate("The project has no other model. Open one first."),
    ),
    "stable.no-points": (
        "error",
        to_translate("Click points around which the rock has not moved."),
    ),
    "stable.no-box": (
        "error",
        to_translate("Set the clipping box of the outcrop first (View > Clipping box)."),
    ),
    "stable.no-model": (
        "error",
        to_translate("Choose the cloud or mesh of the rock that has not moved."),
    ),
    "view.no-earlier": (
        "error",
        to_translate("This is the earliest view."),
    ),
    "view.no-later": (
        "error",
        to_translate("This is the latest view."),
    ),
    "facets.none-open": (
        "error",
        to_translate("All proposed facets were accepted or rejected."),
    ),
    "patch.pending": (
        "info",
        to_translate("The patch is being analysed. Please wait."),
    ),
    "patch.plane-fits": (
        "info",
        to_translate("The plane fits the whole patch, so no trimming is needed."),
    ),
    "extension.pending": (
        "info",
        to_translate("The plane is being extended. Please wait."),
    ),
    "extension.missing": (
        "error",
        to_translate("Show the plane on the outcrop first."),
    ),
}
