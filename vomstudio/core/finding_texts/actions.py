"""Texts of the findings that state why a command, button or field is disabled."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "action.crs-pending": (
        "info",
        to_translate("The coordinate reference system is being looked up. Please wait."),
    ),
    "action.field-without-ends": (
        "info",
        to_translate("This field has no colour range to edit."),
    ),
    "action.first-page": (
        "info",
        to_translate("This is the first page."),
    ),
    "action.frame-unknown": (
        "info",
        to_translate("An unknown frame has no unit. Choose another option above first."),
    ),
    "action.frame-without-crs": (
        "info",
        to_translate(
            "Only projected coordinates have a CRS. Choose Projected coordinates above first."
        ),
    ),
    "action.last-page": (
        "info",
        to_translate("This is the last page."),
    ),
    "action.model-in-project": (
        "info",
        to_translate("The model is already in the project folder."),
    ),
    "action.model-located": (
        "info",
        to_translate("The model's file is already available."),
    ),
    "action.no-cameras": (
        "info",
        to_translate("The model has no cameras. Open them first."),
    ),
    "action.region-set": (
        "info",
        to_translate("A region is set, so only the part inside it is reconstructed."),
    ),
    "action.no-clipping-box": (
        "info",
        to_translate("The clipping box is off. Turn it on first."),
    ),
    "action.no-crs": (
        "info",
        to_translate("Enter a code, name or country, such as EPSG:32633, UTM 33N or Iceland."),
    ),
    "action.no-direction": (
        "info",
        to_translate("The features do not define this direction."),
    ),
    "action.no-such-type": (
        "info",
        to_translate("The list of types has no entry {number}. Add a type first."),
    ),
    "action.no-types": (
        "info",
        to_translate("The active tool has no feature types. Choose Trace, Plane or Line first."),
    ),
    "action.no-feature": (
        "info",
        to_translate("No feature is selected. Select one first."),
    ),
    "action.no-field": (
        "info",
        to_translate("No field is shown."),
    ),
    "action.no-model": (
        "info",
        to_translate("No model is open. Open one first."),
    ),
    "action.no-name": (
        "info",
        to_translate("The view has no name. Enter one first."),
    ),
    "action.no-open-photo": (
        "info",
        to_translate("No photo is open. Open one first."),
    ),
    "action.no-proposals": (
        "info",
        to_translate("Search the model for proposals first."),
    ),
    "action.no-refused-model": (
        "info",
        to_translate("No model was rejected because of its CRS."),
    ),
    "action.no-row": (
        "info",
        to_translate("No list entry is selected. Select one first."),
    ),
    "action.no-saved-view": (
        "info",
        to_translate("No saved view is selected. Select one first."),
    ),
    "action.no-shown-photo": (
        "info",
        to_translate("No photo is shown."),
    ),
    "action.no-surface": (
        "info",
        to_translate("No model with a surface is open. Open one first."),
    ),
    "action.not-one-row": (
        "info",
        to_translate("Select exactly one entry in the list."),
    ),
    "action.nothing-exported": (
        "info",
        to_translate("Nothing has been exported yet. Export something first."),
    ),
    "action.nothing-rejected": (
        "info",
        to_translate("No proposals have been rejected on this model."),
    ),
    "action.project-untitled": (
        "info",
        to_translate("The project is not saved yet. Save it first."),
    ),
    "action.aperture-fixed": (
        "info",
        to_translate("The aperture of this camera is fixed."),
    ),
    "action.control-unusable": (
        "info",
        to_translate("Choose other control points in Reconstruction settings, or none. {reason}"),
    ),
    "action.needs-tool": (
        "info",
        to_translate("The tool {tool} is not active. Activate it first."),
    ),
    "action.no-edited-traces": (
        "info",
        to_translate("No imported drawing has edited traces."),
    ),
    "action.no-elements": (
        "info",
        to_translate("No faces or points are selected. Select some first."),
    ),
    "action.no-grid": (
        "info",
        to_translate("Create a grid on the face first."),
    ),
    "action.no-intersection": (
        "info",
        to_translate("The intersection of the two planes is undefined. Choose other planes."),
    ),
    "action.no-mark": (
        "info",
        to_translate("The point has no mark in this photo. Mark it first."),
    ),
    "action.no-photos": (
        "info",
        to_translate("No photo folder is open. Choose one first."),
    ),
    "action.no-point": (
        "info",
        to_translate("No point is selected. Select one in the list first."),
    ),
    "action.no-reconstruction": (
        "info",
        to_translate("No reconstruction is running."),
    ),
    "action.no-report": (
        "info",
        to_translate("The report is written when the reconstruction has finished."),
    ),
    "action.no-shape": (
        "info",
        to_translate("No shape has been drawn. Draw the shape to copy first."),
    ),
    "action.no-similar-photo": (
        "info",
        to_translate("No other photo has the same size as this one."),
    ),
    "action.no-vertex": (
        "info",
        to_translate("No vertex is selected. Click a vertex of the open feature first."),
    ),
    "action.no-video": (
        "info",
        to_translate("No video is selected. Choose one first."),
    ),
    "action.not-aligned": (
        "info",
        to_translate("The photos have not been aligned yet. Reconstruct them first."),
    ),
    "action.not-by-control": (
        "info",
        to_translate("Control points are not used for registration. Choose them above first."),
    ),
    "action.nothing-hidden": (
        "info",
        to_translate("Nothing is hidden."),
    ),
    "action.nothing-to-continue": (
        "info",
        to_translate("Select a trace, plane, line, rock area, station or measurement first."),
    ),
    "action.one-group": (
        "info",
        to_translate("All planes have the same type and set. Measure another group first."),
    ),
    "action.reconstruction-running": (
        "info",
        to_translate("A reconstruction is running. Wait until it is finished, or pause it."),
    ),
    "action.same-groups": (
        "info",
        to_translate("Both groups of planes are the same. Choose two different groups."),
    ),
    "action.several-features": (
        "info",
        to_translate("Only one feature can be renamed at a time. Select a single feature."),
    ),
    "action.too-few-photos": (
        "info",
        to_translate("A reconstruction needs at least two photos that overlap. Add photos."),
    ),
    "action.type-unused": (
        "info",
        to_translate("No feature has this type."),
    ),
    "action.all-traces-counted": (
        "info",
        to_translate("All traces are counted. Choose a window, circle or scanline to edit."),
    ),
    "action.busy": (
        "info",
        to_translate("The result is being computed. Please wait."),
    ),
    "action.cells-are-window": (
        "info",
        to_translate("The window consists of the grid cells marked done or empty."),
    ),
    "action.clouds-only": (
        "info",
        to_translate("This applies to point clouds only. Choose a point cloud as the model."),
    ),
    "action.direction-by-domain": (
        "info",
        to_translate("Each domain has its own direction. Turn off the domains first."),
    ),
    "action.line-too-short": (
        "info",
        to_translate("Select a trace or line with at least {minimum} points first."),
    ),
    "action.net-empty": (
        "info",
        to_translate("The stereonet is empty. Measure or import something first."),
    ),
    "action.net-loading": (
        "info",
        to_translate("The stereonet is being loaded. Wait a moment."),
    ),
    "action.nets-of-one-face": (
        "info",
        to_translate("Nets are drawn for a single face. Choose One face first."),
    ),
    "action.no-area": (
        "info",
        to_translate("No measured area is selected. Select one first."),
    ),
    "action.no-bins": (
        "info",
        to_translate("A net has no bins. Choose a rose diagram as the view."),
    ),
    "action.no-contours": (
        "info",
        to_translate("The net shows no contours. Turn them on first."),
    ),
    "action.no-line": (
        "info",
        to_translate("No trace or measured polyline is selected. Select one first."),
    ),
    "action.no-other-model": (
        "info",
        to_translate("No other model is selected. Choose one from the project or a file."),
    ),
    "action.no-pick-left": (
        "info",
        to_translate("All picks have already been repeated. Pick more first."),
    ),
    "action.no-result": (
        "info",
        to_translate("Complete the form to get a result."),
    ),
    "action.no-round": (
        "info",
        to_translate("No pick is being repeated. Choose Start re-picking first."),
    ),
    "action.no-sheet": (
        "info",
        to_translate("Only a sheet has a legend. Turn on the sheet first."),
    ),
    "action.no-window": (
        "info",
        to_translate("A selection can only define a window or scanline. Choose one first."),
    ),
    "action.not-computed": (
        "info",
        to_translate("Start the computation to get a result."),
    ),
    "action.not-magnetic": (
        "info",
        to_translate("Only azimuths from magnetic north need a declination."),
    ),
    "action.not-smoothed": (
        "info",
        to_translate("Only Kamb contours are smoothed. Choose a Kamb method first."),
    ),
    "action.not-two-traces": (
        "info",
        to_translate("Select two traces of the same bed first (Ctrl+click adds one)."),
    ),
    "action.other-model-placed": (
        "info",
        to_translate("The other model has been moved in this project. Choose a saved copy of it."),
    ),
    "action.points-are-boundaries": (
        "info",
        to_translate("The points of the line are used as boundaries."),
    ),
    "action.points-of-trace": (
        "info",
        to_translate("The points belong to a trace that is already in the project."),
    ),
    "action.round-running": (
        "info",
        to_translate("Picks are being repeated. Finish or stop re-picking first."),
    ),
    "action.slope-is-facet": (
        "info",
        to_translate("Each facet is analysed as a slope. Choose One face first."),
    ),
    "action.stable-part-without-file": (
        "info",
        to_translate(
            "A command needs a file that defines the stable part. Choose polygons or a model."
        ),
    ),
}
