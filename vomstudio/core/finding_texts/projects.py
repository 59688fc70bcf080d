"""Texts of the findings about projects, their journals, imports and exports."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "project.missing": (
        "error",
        to_translate("The project does not exist. Check its name."),
    ),
    "project.not-a-project": (
        "error",
        to_translate(
            "This is not a VOM Studio project: a folder NAME.vom with journal.sqlite. Check"
            " the name."
        ),
    ),
    "project.newer": (
        "error",
        to_translate(
            "The project was written by a newer VOM Studio (journal version {version}; this"
            " program reads up to {known}). Update the program."
        ),
    ),
    "project.exists": (
        "error",
        to_translate("A project already exists here. Choose another name."),
    ),
    "project.no-models": (
        "error",
        to_translate("The project has no models yet. Add one first."),
    ),
    "project.several-models": (
        "error",
        to_translate("The project has several models. Specify one of them: {names}."),
    ),
    "project.other-model": (
        "error",
        to_translate(
            "No model in the project has this file. Specify one of these models: {models}."
        ),
    ),
    "model.ambiguous-name": (
        "error",
        to_translate("Several models are called {name}. Specify the id of one of them: {ids}."),
    ),
    "model.file-missing": (
        "error",
        to_translate(
            "The file of {model} was not found. Its features are kept. Choose the file with Model >"
            " Locate file."
        ),
    ),
    "model.changed": (
        "error",
        to_translate(
            "The file has changed since features were measured on {model}. Open it as a new model."
        ),
    ),
    "journal.damaged": (
        "error",
        to_translate(
            "The journal is damaged, or is not a journal ({reason}). Restore it from a backup."
        ),
    ),
    "journal.foreign": (
        "error",
        to_translate(
            "This file is not the journal of a VOM Studio project. Restore it from a backup."
        ),
    ),
    "journal.in-use": (
        "error",
        to_translate("The journal is in use by another program. Close it there first."),
    ),
    "journal.not-opened": (
        "error",
        to_translate(
            "The journal cannot be opened for writing ({reason}). Check the drive and its "
            "permissions."
        ),
    ),
    "journal.not-copied": (
        "error",
        to_translate("The journal could not be copied correctly. Choose another location."),
    ),
    "journal.sound": (
        "error",
        to_translate("The journal is intact, so no repair is needed."),
    ),
    "journal.inconsistent": (
        "error",
        to_translate("The readable rows contradict each other. Restore the journal from a backup."),
    ),
    "row.unknown-kind": (
        "error",
        to_translate(
            "This version does not support rows of the kind {kind!r}. Open the project with a"
            " newer version."
        ),
    ),
    "row.target-missing": (
        "error",
        to_translate("The row refers to row {row}, which is missing."),
    ),
    "compaction.unsaved": (
        "error",
        to_translate(
            "The project has unsaved changes, which compaction would delete. Save it first."
        ),
    ),
    "compaction.in-memory": (
        "error",
        to_translate("Some steps exist only in memory. Save the project elsewhere first."),
    ),
    "compaction.damaged": (
        "error",
        to_translate(
            "The journal of the project has damaged rows, which compaction would delete. Repair"
            " the project first."
        ),
    ),
    "compaction.none": (
        "error",
        to_translate(
            "The journal from before the compaction no longer exists, so compaction cannot be"
            " undone."
        ),
    ),
    "asset.outside": (
        "error",
        to_translate(
            "The name {asset} refers to a file outside the project's assets. Restore the project"
            " from a backup."
        ),
    ),
    "asset.missing": (
        "error",
        to_translate(
            "A file of the project is missing. It contained the mask of a photo. Restore the"
            " project from a backup."
        ),
    ),
    "sample.damaged": (
        "error",
        to_translate("The sample is damaged. Install the program again."),
    ),
    "reconstruction.invalid": (
        "error",
        to_translate("This is not the result of a reconstruction. Reconstruct again."),
    ),
    "reconstruction.unreadable": (
        "error",
        to_translate(
            "The file cannot be read, so the results of the reconstruction are lost. Reconstruct"
            " again."
        ),
    ),
    "reconstruction.not-moved": (
        "error",
        to_translate(
            "The project is saved, but its reconstructions remain in {source}: they cannot be"
            " moved ({reason})."
        ),
    ),
    "folder.not-of-photos": (
        "error",
        to_translate("This is not a photo folder. Choose another folder."),
    ),
    "folder.of-photos": (
        "error",
        to_translate("This is the folder of the original photos. Choose another folder."),
    ),
    "table.unreadable": (
        "error",
        to_translate("The table cannot be read ({reason}). Export it again as CSV."),
    ),
    "export.no-features": (
        "error",
        to_translate("The project has no features to export. Measure some first."),
    ),
    "export.written": (
        "info",
        to_translate("Exported to {file}."),
    ),
    "export.nothing-to-write": (
        "error",
        to_translate(
            "The project has nothing to export to {program}: {reason}. Measure such a feature"
            " first, or choose another format."
        ),
    ),
    "export.not-tif": (
        "error",
        to_translate("The name of a GeoTIFF must end in .tif. Add this extension."),
    ),
    "export.not-shp": (
        "error",
        to_translate("The name of a shapefile must end in .shp. Add this extension."),
    ),
    "import.not-vectors": (
        "error",
        to_translate(
            "This file contains no readable vector layers (GeoPackage, GeoJSON, shapefile, DXF,"
            " KML). Export it again."
        ),
    ),
    "import.no-layers": (
        "error",
        to_translate(
            "The file contains no features that can be imported. Draw 3-D lines, or rename the"
            " layers to {layers}."
        ),
    ),
    "import.nothing-usable": (
        "error",
        to_translate("Nothing in the file can be imported. The first problem is {name}: {reason}"),
    ),
    "import.too-few-points": (
        "error",
        *to_translate_n(
            "It has fewer than {count} point. Draw more points.",
            "It has fewer than {count} points. Draw more points.",
        ),
    ),
    "import.no-heights": (
        "error",
        to_translate("It has no heights. Draw it in three dimensions."),
    ),
    "import.no-counterpart": (
        "warning",
        to_translate("A project cannot store this kind of feature. Measure it again on the model."),
    ),
    "import.no-orientation": (
        "warning",
        to_translate("It has no orientation. Fit a plane in the other program first."),
    ),
    "import.no-points": (
        "warning",
        to_translate("It has no points. Export it with its points."),
    ),
    "import.gaps": (
        "warning",
        to_translate("Its segments are not connected. Export it again."),
    ),
    "import.several-shifts": (
        "warning",
        to_translate(
            "The clouds in the file have different global shifts, so the position of the feature is"
            " unknown. Export one cloud."
        ),
    ),
    "import.no-trace-column": (
        "error",
        to_translate(
            "The table does not state which points belong to one trace. Add a header with the"
            " column “trace”."
        ),
    ),
    "import.coordinates-rounded": (
        "warning",
        to_translate(
            "The coordinates in the file have only six digits, so positions are uncertain by"
            " {rounding} m. Use only the orientations."
        ),
    ),
    "import.orientations-differ": (
        "warning",
        to_translate(
            "{count} of {total} orientations in the file differ from those of the imported points"
            " by more than their errors, {name} by {angle}°. Check the file."
        ),
    ),
    "import.type-replaced": (
        "warning",
        to_translate("The project has no feature type {type}, so {used} was used instead."),
    ),
    "project.save-changes": ("info", to_translate("Save the changes to {project}?")),
    "project.memory-lost": (
        "warning",
        to_translate(
            "{failure} Data that exist only in memory are lost unless you save the project"
            " elsewhere."
        ),
    ),
    "reading.no-pick": (
        "info",
        to_translate("The reading cannot be compared: no feature of its type was picked."),
    ),
    "reading.nearest-pick": (
        "info",
        to_translate("{angle} from {pick}, at a distance of {distance}."),
    ),
    "reading.similar-pick": (
        "info",
        to_translate("{angle} from {pick}, the pick with the most similar orientation."),
    ),
    "reading.turned": (
        "info",
        to_translate("The azimuth was changed by {turned_deg:+.2f}° to refer to grid north."),
    ),
    "reading.no-angle": (
        "error",
        to_translate("The row has no azimuth, or no dip or plunge. Enter both angles."),
    ),
    "angle.out-of-range": (
        "error",
        to_translate(
            "{value:g}° is outside {minimum:g} to {maximum:g}. Correct it, or check the order of"
            " the numbers."
        ),
    ),
    "drawing.no-plane": (
        "error",
        to_translate(
            "None of the drawn lines defines a plane. The first problem is {name}: {reason}"
        ),
    ),
    "drawing.unknown-type": (
        "error",
        to_translate(
            "The feature type of lines on these layers is unknown: {layers}. Specify it with"
            " --type."
        ),
    ),
    "drawing.not-a-trace": (
        "error",
        to_translate("Only traces can be updated from drawings. Edit the feature in the project."),
    ),
    "photo.not-showing": (
        "warning",
        to_translate(
            "The photo {photo} does not show both way-points, so this part of the line is"
            " followed on the surface."
        ),
    ),
    "photo.file-missing": (
        "warning",
        to_translate(
            "The file of the photo {photo} was not found, so the line is followed on the surface."
            " Locate the photos."
        ),
    ),
    "journal.rows-missing": (
        "error",
        to_translate("Journal row {first} is missing, and its edit is lost."),
        to_translate("Journal rows {first} to {last} are missing, and their edits are lost."),
    ),
    "journal.row-unreadable": (
        "error",
        to_translate("Journal row {row} ({kind} {label!r}): {reason}"),
    ),
    "row.checksum": (
        "error",
        to_translate("The checksum does not match the row."),
    ),
    "row.not-text": (
        "error",
        to_translate("The kind, label, time or version is not text."),
    ),
    "asset.damaged": (
        "error",
        to_translate(
            "The content of {path} does not match its checksum. Restore it from a backup."
        ),
    ),
    "project.files-left-behind": (
        "warning",
        to_translate(
            "The files of {names} were in the folder that no longer exists. Add them again."
        ),
    ),
    "journal.folder-gone": (
        "error",
        to_translate(
            "The project folder no longer exists: it was deleted or renamed, or its drive was"
            " removed. Restore it, or save the project elsewhere."
        ),
    ),
    "journal.gone": (
        "error",
        to_translate(
            "The project's journal no longer exists: it was deleted or renamed. Restore it, or"
            " save the project elsewhere."
        ),
    ),
    "journal.replaced": (
        "error",
        to_translate(
            "The project was replaced by a copy, or changed by another program. Restore it, or"
            " save the project elsewhere."
        ),
    ),
    "journal.not-written": (
        "error",
        to_translate(
            "The project's journal cannot be written ({reason}). Check the drive, or save "
            "the project elsewhere."
        ),
    ),
    "asset.unreadable": (
        "error",
        to_translate("{path} cannot be read ({reason}). Restore it from a backup."),
    ),
    "project.steps-in-memory": (
        "error",
        to_translate("{reason} Until then, your steps exist only in memory."),
    ),
    "reading.declination-column": (
        "warning",
        to_translate(
            "The column “{column}” ({first}) is not applied automatically. Choose the north"
            " reference and enter the declination."
        ),
        to_translate(
            "The column “{column}” ({count} different values) is not applied automatically."
            " Choose the north reference and enter the declination."
        ),
    ),
    "reading.columns-missing": (
        "error",
        to_translate(
            "Choose the columns of both angles (missing: {roles}), or a single column that"
            " contains both."
        ),
    ),
    "reading.notation-missing": (
        "error",
        to_translate(
            "Choose the notation. The numbers alone do not show whether they are strikes or dip"
            " directions."
        ),
    ),
    "reading.type-unclear": (
        "error",
        to_translate(
            "Choose a type for {types}. Their names do not show whether they are planes or lines."
        ),
    ),
    "reading.lines-by-type": (
        "info",
        to_translate("{count} row of {types} is read as a line: trend and plunge."),
        to_translate("{count} rows of {types} are read as lines: trend and plunge."),
    ),
    "reading.new-types": (
        "info",
        to_translate("New feature types: {types}."),
    ),
    "reading.upward": (
        "info",
        to_translate("{count} lineation plunges upward. Its downward end is stored ({lines})."),
        to_translate("{count} lineations plunge upward. Their downward ends are stored ({lines})."),
    ),
    "reading.degrees-without-crs": (
        "warning",
        to_translate(
            "{count} reading is imported without a position, because positions in degrees need a"
            " project with a CRS ({lines})."
        ),
        to_translate(
            "{count} readings are imported without positions, because positions in degrees need a"
            " project with a CRS ({lines})."
        ),
    ),
    "reading.coordinate-missing": (
        "warning",
        to_translate(
            "{count} reading is imported without a position: x, y or z is missing ({lines})."
        ),
        to_translate(
            "{count} readings are imported without positions: x, y or z is missing ({lines})."
        ),
    ),
    "reading.no-position": (
        "warning",
        to_translate("{count} reading is imported without a position ({lines}). {reason}"),
        to_translate("{count} readings are imported without positions ({lines}). {reason}"),
    ),
    "compaction.done": (
        "info",
        to_translate(
            "The project has been compacted. This can be undone until the project is closed."
        ),
    ),
    "compaction.nothing-to-remove": (
        "info",
        to_translate("There is nothing to remove: undo and redo can still reach all edits."),
    ),
    "compaction.undone": (
        "info",
        to_translate(
            "The journal is complete again, including the edits made since the compaction."
        ),
    ),
    "compaction.not-done": (
        "error",
        to_translate("The project has not been compacted since it was opened."),
    ),
    "reading.north-missing": (
        "error",
        to_translate("Choose the north reference of the azimuths."),
    ),
    "reading.declination-missing": (
        "error",
        to_translate(
            "Enter the declination in degrees, east positive, as printed in the map margin. Enter"
            " 0 if it was already set on the compass."
        ),
    ),
    "reading.far-from-model": (
        "warning",
        to_translate(
            "The positions are {distance_m:,.0f} m away from the model. Check that they are in"
            " the model's CRS."
        ),
    ),
    "project.unsaved-found": (
        "warning",
        to_translate("The last session left unsaved work."),
    ),
    "project.unclosed": (
        "warning",
        to_translate(
            "{project} was open when the program last stopped. You can restore your work."
        ),
    ),
    "project.older-unclosed": (
        "warning",
        *to_translate_n(
            "{count} older project was also found.",
            "{count} older projects were also found.",
        ),
    ),
}
