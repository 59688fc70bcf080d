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
        to_translate("The outline has no area. Pick points around the rock."),
    ),
    "tool.other-kind": (
        "error",
        to_translate(
            "This tool cannot continue a feature of this kind. Choose the tool that made it."
        ),
    ),
    "line.from-compass": (
        "error",
        to_translate("{name} was read by compass. Change the reading in the list."),
    ),
    "model.not-open": (
        "error",
        to_translate("The model is not open. Open it, or locate its file first."),
    ),
    "feature.open": (
        "error",
        to_translate("A feature is open. Finish it (Enter) or cancel it (Esc) first."),
    ),
    "tool.discarded": (
        "info",
        to_translate("The unfinished feature was discarded. Undo restores it."),
    ),
    "tool.path-pending": (
        "info",
        to_translate("The path of the previous feature is being searched. Paint when it is kept."),
    ),
    "tool.clicks-dropped": (
        "info",
        to_translate("{count} click of an unfinished feature was dropped. Click again."),
        to_translate("{count} clicks of an unfinished feature were dropped. Click again."),
    ),
    "tool.no-shape": (
        "error",
        to_translate("No shape is being drawn. Draw one over the outcrop."),
    ),
    "tool.selection-restored": (
        "info",
        to_translate("An unfinished selection of {count:,} element was restored."),
        to_translate("An unfinished selection of {count:,} elements was restored."),
    ),
    "plane.nothing-chosen": (
        "error",
        to_translate("No plane has been begun. Click or paint the outcrop."),
    ),
    "selection.no-feature-inside": (
        "info",
        to_translate("No visible feature has its centre inside. Draw a larger shape."),
    ),
    "view.no-normal": (
        "error",
        to_translate("The surface has no normal there. Choose a smoother place."),
    ),
    "place.copied": (
        "info",
        to_translate("The coordinates {place} were copied."),
    ),
    "type.other-geometry": (
        "warning",
        to_translate("{type} does not suit all of these features. The others are unchanged."),
    ),
    "type.shown-again": (
        "info",
        to_translate("{types} was hidden and is shown again for the new feature."),
    ),
    "tool.nothing-open": (
        "error",
        to_translate("No feature is open. Click on the outcrop to begin one."),
    ),
    "feature.too-few-points": (
        "error",
        to_translate("Pick {count} more point: at least {minimum} are needed."),
        to_translate("Pick {count} more points: at least {minimum} are needed."),
    ),
    "thickness.no-plane": (
        "error",
        to_translate("A thickness is measured across a plane. Choose one."),
    ),
    "thickness.plane-lost": (
        "error",
        to_translate(
            "The plane across which the thickness is measured was deleted or has no fit. "
            "Choose another one."
        ),
    ),
    "tool.no-surface": (
        "error",
        to_translate("The cursor is not on the surface. Click on the outcrop."),
    ),
    "tool.other-model": (
        "error",
        to_translate(
            "This point lies on another model. Finish the open feature (Enter) or cancel it"
            " (Esc) first."
        ),
    ),
    "model.removed": (
        "error",
        to_translate("This model has been removed from the project. Undo restores it."),
    ),
    "growth.no-plane": (
        "error",
        to_translate(
            "The points there do not define a plane. Click where the surface is denser or smoother."
        ),
    ),
    "growth.isolated": (
        "warning",
        to_translate("No neighbour is within the tolerances. Raise the angle or the distance."),
    ),
    "growth.stopped": (
        "warning",
        to_translate("Growth was stopped at {count:,}. Lower the angle or the distance."),
    ),
    "growth.whole-model": (
        "warning",
        to_translate("The selection covers the whole model. Lower the angle or the distance."),
    ),
    "neighbours.pending": (
        "info",
        to_translate("The neighbour graph is being built. The selection follows when it is ready."),
    ),
    "selection.no-model": (
        "error",
        to_translate("No model is open and visible, so nothing can be selected. Open or show one."),
    ),
    "selection.no-change": (
        "warning",
        to_translate("The selection stays the same. Choose another place or a larger tolerance."),
    ),
    "selection.too-many": (
        "error",
        to_translate(
            "{count:,} are too many for one plane: at most {maximum:,}. Choose a smaller area."
        ),
    ),
    "selection.not-in-photo": (
        "error",
        to_translate("Shapes are drawn over the outcrop. In a photo choose Grow and paint (G)."),
    ),
    "selection.nothing-inside": (
        "error",
        to_translate(
            "Nothing selectable lies inside. Draw a larger shape, come nearer, or select "
            "through the surface."
        ),
    ),
    "selection.no-such-value": (
        "error",
        to_translate("No element has such a value. Enter a wider range."),
    ),
    "selection.hold-button": (
        "info",
        to_translate("Hold the left button and draw around what you want."),
    ),
    "cells.marked-at-once": (
        "info",
        to_translate("Cells are marked at once. Undo removes a mark."),
    ),
    "tool.draft-unreadable": (
        "warning",
        to_translate("An unfinished feature could not be read and was left out."),
    ),
    "tool.draft-kept": (
        "info",
        to_translate(
            "The open feature stays unfinished. Finish it with Enter or cancel it with Esc."
        ),
    ),
    "tool.draft-restored": (
        "info",
        to_translate(
            "An unfinished feature with {count} point was restored. You can go on picking."
        ),
        to_translate(
            "An unfinished feature with {count} points was restored. You can go on picking."
        ),
    ),
    "slip.no-plane": (
        "error",
        to_translate("First choose the plane on which the line lies."),
    ),
    "feature.continued": (
        "error",
        to_translate("Change the attributes of a continued feature in Properties."),
    ),
    "measurement.continued": (
        "info",
        to_translate(
            "A continued measurement keeps its kind and plane. Begin a new one to change them."
        ),
    ),
    "follow.continued": (
        "error",
        to_translate("A continued feature is picked point by point."),
    ),
    "follow.by-cost": (
        "info",
        to_translate("Followed by {cost} through {points} way-points."),
    ),
    "follow.by-best-cost": (
        "info",
        to_translate(
            "Followed by {cost}, the cost that gives the best plane, through {points} way-points."
        ),
    ),
    "follow.searching": ("info", to_translate("Searching for the path.")),
    "follow.finishing": ("info", to_translate("Finished when the path is found.")),
    "follow.clicks-waiting": (
        "info",
        to_translate("{count} click waits for the next feature."),
        to_translate("{count} clicks wait for the next feature."),
    ),
    "follow.no-cost": (
        "error",
        to_translate("Choose an entry under Follow first."),
    ),
    "follow.not-in-photos": (
        "error",
        to_translate(
            "Photos show colours and lightness. Choose one of these under Follow to follow "
            "it in photos."
        ),
    ),
    "follow.reading-cameras": (
        "info",
        to_translate("The cameras of the photos are being read. Wait until they are loaded."),
    ),
    "follow.no-cameras": (
        "error",
        to_translate(
            "No photos with known cameras are in use. Open the panel In the photos, or the "
            "cameras of the model there."
        ),
    ),
    "follow.no-network": (
        "error",
        to_translate("Choose the ONNX file of the network first."),
    ),
}
