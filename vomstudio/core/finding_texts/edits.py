"""Texts of the findings about edits and records of a project."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "proposals.none": (
        "error",
        to_translate(
            "None of the {proposed} proposals has the quality {quality}, so nothing was added."
            " Change the search options."
        ),
    ),
    "proposals.not-found": (
        "error",
        to_translate(
            "The search found nothing new on {model}, so nothing was added. Change the search"
            " options."
        ),
    ),
    "edit.stale": (
        "error",
        to_translate("{label}: the record {record} has changed in the meantime. Try again."),
    ),
    "edit.no-change": (
        "error",
        to_translate("The features already have these values."),
    ),
    "edit.empty": (
        "error",
        to_translate("The edit does not contain any features. Add at least one."),
    ),
    "edit.nothing-to-undo": (
        "error",
        to_translate("There is nothing to undo."),
    ),
    "edit.nothing-to-redo": (
        "error",
        to_translate("There is nothing to redo."),
    ),
    "selection.empty": (
        "error",
        to_translate("Nothing is selected. Select a feature first."),
    ),
    "record.missing": (
        "error",
        to_translate("The project has no {kind} {id!r}. Check the id."),
    ),
    "record.exists": (
        "error",
        to_translate("{name} is already in the project."),
    ),
    "record.unknown-kind": (
        "error",
        to_translate(
            "The record has the unknown kind {kind!r}. Update the program, or restore the journal"
            " from a backup."
        ),
    ),
    "record.unknown-field": (
        "error",
        to_translate(
            "A record of kind {kind} has an unknown field. Update the program, or restore the"
            " journal from a backup."
        ),
    ),
    "record.missing-field": (
        "error",
        to_translate(
            "A record of kind {kind} lacks a field: {error}. Restore the journal from a backup."
        ),
    ),
    "record.wrong-value": (
        "error",
        to_translate("The value is not valid for this field. Restore the journal from a backup."),
    ),
    "record.two-ids": (
        "error",
        to_translate("The record has two ids. Restore the journal from a backup."),
    ),
    "record.without-base": (
        "error",
        to_translate("The row changes {record}, but the row that added it cannot be read."),
    ),
    "name.empty": (
        "error",
        to_translate("The name is empty. Enter one."),
    ),
    "name.too-long": (
        "error",
        to_translate("The name has {count:,} characters. Use at most {limit}."),
    ),
    "name.taken": (
        "error",
        to_translate("The name {name} is already in use. Choose another one."),
    ),
    "name.of-several": (
        "error",
        to_translate("{count} features cannot have the same name. Select one of them."),
    ),
    "type.in-use": (
        "error",
        to_translate("{count} feature has the type {type}. Give it another type first."),
        to_translate("{count} features have the type {type}. Give them another type first."),
    ),
    "type.last": (
        "error",
        to_translate("The last feature type cannot be removed. Add another one first."),
    ),
    "type.colour": (
        "error",
        to_translate("{colour!r} is not a colour. Use the form #rrggbb, such as #d55e00."),
    ),
    "profile.fixed": (
        "error",
        to_translate(
            "The limits of the profile “{profile}” cannot be changed. Save your own under another"
            " name."
        ),
    ),
    "profile.limit-not-positive": (
        "error",
        to_translate("The limit {value:g} of the profile is not a positive number. Correct it."),
    ),
    "profile.limits-crossed": (
        "error",
        to_translate(
            "The error limit of a good plane ({good_deg:g}°) exceeds that of a poor one"
            " ({poor_deg:g}°). Swap them."
        ),
    ),
    "model.registered": (
        "error",
        to_translate(
            "{model} is placed by the registration “{registration}”, which a declared frame would"
            " replace. Remove the registration first."
        ),
    ),
    "model.other-file": (
        "error",
        to_translate(
            "{path} is not the file on which features of {model} were measured. Open it as"
            " another model."
        ),
    ),
    "model.in-use": (
        "error",
        to_translate(
            "{count} feature was measured on {model}. Delete the feature first, or hide the model."
        ),
        to_translate(
            "{count} features were measured on {model}. Delete the features first, or hide the"
            " model."
        ),
    ),
    "frame.unit-not-positive": (
        "error",
        to_translate("The unit must be a positive length in metres. Correct it."),
    ),
    "frame.code-missing": (
        "error",
        to_translate("The coordinate reference system has no code. Enter one, such as EPSG:32633."),
    ),
    "surroundings.up-to-date": (
        "error",
        to_translate("All features are up to date: they were measured with the current method."),
    ),
    "feature.has-plane": (
        "error",
        to_translate("{feature} has a plane fitted to its vertices. Edit the feature as a trace."),
    ),
    "feature.no-attribute": (
        "error",
        to_translate("{feature} has no {attribute}."),
    ),
    "feature.on-other-model": (
        "error",
        to_translate("{feature} is not on {model}. Select a feature on {model}."),
    ),
    "bed.no-line": (
        "error",
        to_translate("A log needs a trace, a contact line or a measured polyline. Select one."),
    ),
    "domain.no-plane": (
        "error",
        to_translate("Select a plane that was picked on the model, such as a fault."),
    ),
    "grid.cell-size": (
        "error",
        to_translate("A grid needs cells with a positive size. Enter one."),
    ),
    "grid.not-begun": (
        "info",
        to_translate("Create a grid on the face, then mark its cells as you inspect them."),
    ),
    "grid.no-cell": (
        "error",
        to_translate("The grid has no such cell. Choose a cell inside it."),
    ),
    "repeat.other-kind": (
        "error",
        to_translate(
            "A repeat must be of the same kind as its first pick. Select a feature of this kind."
        ),
    ),
    "repeat.of-repeat": (
        "error",
        to_translate("{feature} is itself a repeat. Select its first pick."),
    ),
    "view.name-length": (
        "error",
        to_translate("The name of a view has at most {maximum} characters. Enter a shorter name."),
    ),
    "view.too-many": (
        "error",
        to_translate("A project can store at most {maximum} views. Delete one first."),
    ),
    "readings.no-picks": (
        "info",
        to_translate("{count} reading has no pick of its type for comparison."),
        to_translate("{count} readings have no picks of their types for comparison."),
    ),
    "readings.compared": (
        "info",
        to_translate(
            "{count} reading differs by {median_deg:.0f}° from the nearest pick of its type."
        ),
        to_translate(
            "{count} readings, {compared} compared with the nearest pick of their type: "
            "median difference {median_deg:.0f}°."
        ),
    ),
    "edit.undone": (
        "info",
        to_translate("Undone: {edit}"),
    ),
    "edit.redone": (
        "info",
        to_translate("Redone: {edit}"),
    ),
}
