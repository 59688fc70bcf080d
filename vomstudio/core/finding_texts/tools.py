"""Texts of the findings about tools and selections."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "tool.no-points": (
        "error",
        to_translate("No points have been picked. Click on the outcrop."),
    ),
    "points.coincident": (
        "error",
        to_translate("All points coincide. Pick them farther apart."),
    ),
    "tool.no-area": (
        "error",
        to_translate("The outline has zero area. Pick points around the rock."),
    ),
    "tool.other-kind": (
        "error",
        to_translate(
            "This tool cannot edit a feature of this kind. Choose the tool that created it."
        ),
    ),
    "line.from-compass": (
        "error",
        to_translate("{name} is a compass reading. Change its value in the list."),
    ),
    "model.not-open": (
        "error",
        to_translate("The model is not open. Open it, or locate its file first."),
    ),
    "feature.open": (
        "error",
        to_translate("There is an unfinished feature. Finish it (Enter) or cancel it (Esc) first."),
    ),
    "tool.discarded": (
        "info",
        to_translate("The unfinished feature was discarded. Undo restores it."),
    ),
    "tool.path-pending": (
        "info",
        to_translate(
            "The path of the previous feature is still being computed. Paint after the feature has"
            " been saved."
        ),
    ),
    "tool.clicks-dropped": (
        "info",
        to_translate("{count} click of an unfinished feature was discarded. Click again."),
        to_translate("{count} clicks of an unfinished feature were discarded. Click again."),
    ),
    "tool.no-shape": (
        "error",
        to_translate("No shape is being drawn. Draw one on the outcrop."),
    ),
    "tool.selection-restored": (
        "info",
        to_translate("An unfinished selection of {count:,} element was restored."),
        to_translate("An unfinished selection of {count:,} elements was restored."),
    ),
    "plane.nothing-chosen": (
        "error",
        to_translate("No plane has been started. Click or paint on the outcrop."),
    ),
    "selection.no-feature-inside": (
        "info",
        to_translate(
            "The shape does not contain the centre of any visible feature. Draw a larger shape."
        ),
    ),
    "view.no-normal": (
        "error",
        to_translate("The surface has no normal at this point. Choose a smoother part."),
    ),
    "place.copied": (
        "info",
        to_translate("The coordinates {place} have been copied."),
    ),
    "type.other-geometry": (
        "warning",
        to_translate("{type} is not suitable for some of these features, which are unchanged."),
    ),
    "type.shown-again": (
        "info",
        to_translate("{types} was hidden and is now visible again for the new feature."),
    ),
    "tool.nothing-open": (
        "error",
        to_translate("Click on the outcrop to start a feature."),
    ),
    "feature.too-few-points": (
        "error",
        to_translate("Pick {count} more point: at least {minimum} are required."),
        to_translate("Pick {count} more points: at least {minimum} are required."),
    ),
    "thickness.no-plane": (
        "error",
        to_translate("Thickness is measured perpendicular to a plane. Choose a plane."),
    ),
    "thickness.plane-lost": (
        "error",
        to_translate(
            "The reference plane of the thickness was deleted or has no fit. Choose another one."
        ),
    ),
    "tool.no-surface": (
        "error",
        to_translate("The cursor is not on the surface. Click on the outcrop."),
    ),
    "tool.other-model": (
        "error",
        to_translate(
            "This point is on another model. Finish the open feature (Enter) or cancel it (Esc)"
            " first."
        ),
    ),
    "model.removed": (
        "error",
        to_translate("This model has been removed from the project. Undo restores it."),
    ),
    "growth.no-plane": (
        "error",
        to_translate(
            "The points here do not define a plane. Click where the surface is denser or smoother."
        ),
    ),
    "growth.isolated": (
        "warning",
        to_translate("No neighbour is within the tolerances. Increase the angle or the distance."),
    ),
    "growth.stopped": (
        "warning",
        to_translate("Growth stopped at {count:,} elements. Reduce the angle or the distance."),
    ),
    "growth.whole-model": (
        "warning",
        to_translate("The selection covers the whole model. Reduce the angle or the distance."),
    ),
    "neighbours.pending": (
        "info",
        to_translate(
            "The neighbour graph is being built. The selection will appear when it is ready."
        ),
    ),
    "selection.no-model": (
        "error",
        to_translate("No visible model is open, so nothing can be selected. Open or show one."),
    ),
    "selection.no-change": (
        "warning",
        to_translate(
            "The selection has not changed. Choose another position or a larger tolerance."
        ),
    ),
    "selection.too-many": (
        "error",
        to_translate(
            "{count:,} elements are too many for one plane (maximum {maximum:,}). Choose a"
            " smaller area."
        ),
    ),
    "selection.not-in-photo": (
        "error",
        to_translate("Shapes are drawn on the outcrop only. In a photo choose Grow and paint (G)."),
    ),
    "selection.nothing-inside": (
        "error",
        to_translate(
            "The shape contains nothing that can be selected. Draw a larger shape, zoom in, or"
            " select through the surface."
        ),
    ),
    "selection.no-such-value": (
        "error",
        to_translate("No element has a value in this range. Enter a wider range."),
    ),
    "selection.hold-button": (
        "info",
        to_translate("Hold the left button and draw around the part to select."),
    ),
    "cells.marked-at-once": (
        "info",
        to_translate("Cells are marked immediately. Undo removes a mark."),
    ),
    "tool.draft-unreadable": (
        "warning",
        to_translate("An unfinished feature could not be read and was left out."),
    ),
    "tool.draft-kept": (
        "info",
        to_translate(
            "The open feature remains unfinished. Finish it with Enter or cancel it with Esc."
        ),
    ),
    "tool.draft-restored": (
        "info",
        to_translate(
            "An unfinished feature with {count} point was restored. You can continue picking."
        ),
        to_translate(
            "An unfinished feature with {count} points was restored. You can continue picking."
        ),
    ),
    "slip.no-plane": (
        "error",
        to_translate("First choose the plane that contains the line."),
    ),
    "feature.continued": (
        "error",
        to_translate("Change the attributes of an edited feature in Properties."),
    ),
    "measurement.continued": (
        "info",
        to_translate(
            "An edited measurement keeps its kind and plane. Start a new one to change them."
        ),
    ),
    "follow.continued": (
        "error",
        to_translate(
            "While a feature is edited, its path cannot be followed. Pick its points one by one."
        ),
    ),
    "follow.by-cost": (
        "info",
        to_translate("Followed through {points} way-points, using the cost {cost}."),
    ),
    "follow.by-best-cost": (
        "info",
        to_translate(
            "Followed through {points} way-points, using the cost with the best plane, {cost}."
        ),
    ),
    "follow.searching": ("info", to_translate("Tracing…")),
    "follow.finishing": ("info", to_translate("The feature will be saved when its path is ready.")),
    "follow.clicks-waiting": (
        "info",
        to_translate("{count} click is queued for the next feature."),
        to_translate("{count} clicks are queued for the next feature."),
    ),
    "follow.no-cost": (
        "error",
        to_translate("Choose an entry under Follow first."),
    ),
    "follow.not-in-photos": (
        "error",
        to_translate(
            "Photos show only colour and brightness. Choose one of these under Follow to use"
            " photos."
        ),
    ),
    "follow.reading-cameras": (
        "info",
        to_translate("The cameras of the photos are being read. Please wait."),
    ),
    "follow.no-cameras": (
        "error",
        to_translate(
            "No photos with known cameras are open. Open the panel In the photos, or the cameras"
            " of the model there."
        ),
    ),
    "follow.no-network": (
        "error",
        to_translate("Choose the ONNX file of the network first."),
    ),
}
