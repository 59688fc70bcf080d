"""Texts of the findings that state why a command, button or field is disabled."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "action.model-in-project": (
        "info",
        to_translate("The model is already in the project folder."),
    ),
    "action.model-located": (
        "info",
        to_translate("The file of the model has been found."),
    ),
    "action.no-feature": (
        "info",
        to_translate("No feature is selected. Select one first."),
    ),
    "action.no-model": (
        "info",
        to_translate("No model is open. Open one first."),
    ),
    "action.no-refused-model": (
        "info",
        to_translate("No model was refused because of its CRS."),
    ),
    "action.no-proposals": (
        "info",
        to_translate("Nothing is proposed. Search the model first."),
    ),
    "action.no-row": (
        "info",
        to_translate("No entry of the list is selected. Select one first."),
    ),
    "action.not-one-row": (
        "info",
        to_translate("The list does not have one selected entry. Select exactly one."),
    ),
    "action.nothing-exported": (
        "info",
        to_translate("Nothing has been exported yet. Export something first."),
    ),
    "action.nothing-rejected": (
        "info",
        to_translate("Nothing was rejected on this model."),
    ),
    "action.project-untitled": (
        "info",
        to_translate("The project is not saved yet. Save it first."),
    ),
}
