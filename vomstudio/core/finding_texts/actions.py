"""Texts of the findings that state why a command, button or field is disabled."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "action.crs-pending": (
        "info",
        to_translate("The coordinate reference system is being looked up."),
    ),
    "action.field-without-ends": (
        "info",
        to_translate("The colours of this field have no range."),
    ),
    "action.first-page": (
        "info",
        to_translate("This is the first page."),
    ),
    "action.frame-unknown": (
        "info",
        to_translate("The unit is not used. Choose above how much of the frame is known."),
    ),
    "action.frame-without-crs": (
        "info",
        to_translate("The frame has no coordinate system. Choose Projected coordinates above."),
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
        to_translate("The file of the model has been found."),
    ),
    "action.no-cameras": (
        "info",
        to_translate("The model has no cameras. Open them first."),
    ),
    "action.no-clipping-box": (
        "info",
        to_translate("The clipping box is off. Switch it on first."),
    ),
    "action.no-crs": (
        "info",
        to_translate("Enter a code, name or country, such as EPSG:32633, UTM 33N or Iceland."),
    ),
    "action.no-direction": (
        "info",
        to_translate("The features define no such direction."),
    ),
    "action.no-such-type": (
        "info",
        to_translate("The list of types has no entry {number}. Add a type first."),
    ),
    "action.no-types": (
        "info",
        to_translate("No tool with types is active. Choose Trace, Plane or Line first."),
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
        to_translate("Nothing is proposed. Search the model first."),
    ),
    "action.no-refused-model": (
        "info",
        to_translate("No model was refused because of its CRS."),
    ),
    "action.no-row": (
        "info",
        to_translate("No entry of the list is selected. Select one first."),
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
    "action.aperture-fixed": (
        "info",
        to_translate("The aperture of this camera is fixed."),
    ),
    "action.control-unusable": (
        "info",
        to_translate("Choose other control points, or none, in Reconstruction settings: {reason}"),
    ),
    "action.needs-tool": (
        "info",
        to_translate("The tool {tool} is not active. Choose it first."),
    ),
    "action.no-edited-traces": (
        "info",
        to_translate("No imported drawing has edited traces."),
    ),
    "action.no-elements": (
        "info",
        to_translate("No face or point is selected. Select some first."),
    ),
    "action.no-grid": (
        "info",
        to_translate("There is no grid. Lay one over the face first."),
    ),
    "action.no-intersection": (
        "info",
        to_translate("The two planes have no known line of intersection. Choose other planes."),
    ),
    "action.no-mark": (
        "info",
        to_translate("The point is not marked in this photo. Mark it first."),
    ),
    "action.no-photos": (
        "info",
        to_translate("No folder of photos is open. Choose one first."),
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
        to_translate("The report is not written yet. Finish the reconstruction first."),
    ),
    "action.no-shape": (
        "info",
        to_translate("No shape was drawn. Draw the one that all masks need first."),
    ),
    "action.no-similar-photo": (
        "info",
        to_translate("No other photo has the size of this one."),
    ),
    "action.no-vertex": (
        "info",
        to_translate("No vertex is marked. Click one of the open feature first."),
    ),
    "action.no-video": (
        "info",
        to_translate("No video is chosen. Choose one first."),
    ),
    "action.not-aligned": (
        "info",
        to_translate("The photos are not aligned yet. Reconstruct them first."),
    ),
    "action.not-by-control": (
        "info",
        to_translate("The model is not placed by control points. Choose them above first."),
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
        to_translate("All planes are of one type and set. Measure another group first."),
    ),
    "action.reconstruction-running": (
        "info",
        to_translate("A reconstruction is running. Wait until it is finished, or pause it."),
    ),
    "action.same-groups": (
        "info",
        to_translate("Both groups of planes are the same. Choose two different ones."),
    ),
    "action.several-features": (
        "info",
        to_translate("A name belongs to one feature. Select only one."),
    ),
    "action.too-few-photos": (
        "info",
        to_translate("A reconstruction needs at least two photos that overlap. Add photos."),
    ),
    "action.type-unused": (
        "info",
        to_translate("No feature is of this type."),
    ),
    "action.all-traces-counted": (
        "info",
        to_translate("All traces are counted. Choose a window, circle or scanline."),
    ),
    "action.busy": (
        "info",
        to_translate("The result is being computed. Wait a moment."),
    ),
    "action.cells-are-window": (
        "info",
        to_translate("The done and empty cells of the grid are the window."),
    ),
    "action.clouds-only": (
        "info",
        to_translate("This applies to point clouds only. Choose one as the model."),
    ),
    "action.direction-by-domain": (
        "info",
        to_translate("Each domain has its own direction. Switch the domains off first."),
    ),
    "action.line-too-short": (
        "info",
        to_translate("Select a trace or line of at least {minimum} points first."),
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
        to_translate("The nets show one face. Choose One face."),
    ),
    "action.no-area": (
        "info",
        to_translate("No measured area is selected. Select one first."),
    ),
    "action.no-bins": (
        "info",
        to_translate("A net has no bins. Choose a rose as the view."),
    ),
    "action.no-contours": (
        "info",
        to_translate("The net shows no contours. Choose some first."),
    ),
    "action.no-line": (
        "info",
        to_translate("No trace or measured polyline is selected. Select one first."),
    ),
    "action.no-other-model": (
        "info",
        to_translate("Choose the other model first, from the project or a file."),
    ),
    "action.no-pick-left": (
        "info",
        to_translate("All picks were repeated already. Pick more first."),
    ),
    "action.no-result": (
        "info",
        to_translate("There is no result yet. Complete the form first."),
    ),
    "action.no-round": (
        "info",
        to_translate("No pick is offered. Choose Offer picks again first."),
    ),
    "action.no-sheet": (
        "info",
        to_translate("Only a sheet has a legend. Write a sheet too."),
    ),
    "action.no-window": (
        "info",
        to_translate("Only a window or a scanline can be taken. Choose one."),
    ),
    "action.not-computed": (
        "info",
        to_translate("There is no result yet. Start the computation first."),
    ),
    "action.not-magnetic": (
        "info",
        to_translate("Only azimuths from magnetic north need a declination."),
    ),
    "action.not-smoothed": (
        "info",
        to_translate("Only Kamb contours are smoothed. Choose them first."),
    ),
    "action.not-two-traces": (
        "info",
        to_translate("Select two traces of one bed first (Ctrl adds one)."),
    ),
    "action.other-model-placed": (
        "info",
        to_translate("The other model was moved in this project. Choose a saved copy of it."),
    ),
    "action.points-are-boundaries": (
        "info",
        to_translate("The points of the line are the boundaries."),
    ),
    "action.points-of-trace": (
        "info",
        to_translate("The points belong to a trace, which is in the project."),
    ),
    "action.round-running": (
        "info",
        to_translate("Picks are being repeated. Finish or stop this first."),
    ),
    "action.slope-is-facet": (
        "info",
        to_translate("The slope is each facet. Choose One face first."),
    ),
    "action.stable-part-without-file": (
        "info",
        to_translate("A command needs polygons or a model as the stable part."),
    ),
}
