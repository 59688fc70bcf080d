"""Texts of the findings about jobs, their worker processes and failures, and clusters."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "job.worker-died": (
        "error",
        to_translate(
            "The worker process ended unexpectedly ({ending}). Finished results are kept. {remedy}"
        ),
    ),
    "job.out-of-memory": (
        "error",
        to_translate("There is not enough memory for this task. {remedy}"),
    ),
    "job.closing": (
        "error",
        to_translate("The program is closing, so no new work is started."),
    ),
    "job.no-worker": (
        "error",
        to_translate("The worker process cannot be started ({reason}). Close other programs."),
    ),
    "job.unknown-task": (
        "error",
        to_translate("This version has no task “{task}”. Restart the program."),
    ),
    "job.failed": (
        "error",
        to_translate("The task “{task}” failed: {type}: {error}."),
    ),
    "job.unsendable": (
        "error",
        to_translate("The field '{name}' ({type}) cannot be sent to another process."),
    ),
    "job.wrong-value": (
        "error",
        to_translate("The field '{name}' must be of type {type}, but its value is {value}."),
    ),
    "job.unknown-field": (
        "error",
        to_translate("{type} has no field '{name}'."),
    ),
    "job.missing-field": (
        "error",
        to_translate("The field '{name}' of {type} is missing."),
    ),
    "cluster.no-dask": (
        "error",
        to_translate("The cluster needs Dask. Install it with: pip install 'vomstudio[cluster]'."),
    ),
    "cluster.no-scheduler": (
        "error",
        to_translate("No Dask scheduler responds at {address}. Start one, or omit this option."),
    ),
    "cluster.no-workers": (
        "error",
        to_translate(
            "The scheduler at {address} has no workers. Start some with: dask worker {address}."
        ),
    ),
    "cluster.workers-lost": (
        "error",
        to_translate(
            "The cluster has lost all its workers. Finished results are kept. Start workers"
            " and try again."
        ),
    ),
    "cluster.part-lost": (
        "error",
        to_translate(
            "The cluster failed {tries} times on the same task ({error}), probably for lack of"
            " memory. Finished results are kept. Give each worker more memory."
        ),
    ),
    "edges.network-unused": (
        "error",
        to_translate(
            'A network is only used with the cost "onnx". Choose this cost, or omit the network.'
        ),
    ),
    "edges.no-network": (
        "error",
        to_translate('The cost "onnx" needs a network. Specify its file with {option}.'),
    ),
    "cost.needs-way-points": (
        "error",
        to_translate(
            'The cost "{cost}" needs way-points, so it cannot propose lines. Use gradient,'
            " curvature, dark, light or a field."
        ),
    ),
    "job.internal-error": (
        "error",
        to_translate(
            "{job}: an internal error occurred ({error}). Your project is unchanged. Please save"
            " a report, so that the error can be fixed."
        ),
    ),
    "program.internal-error": (
        "error",
        to_translate(
            "An internal error occurred ({error}). At most your last action is lost. Please save"
            " a report, so that the error can be fixed."
        ),
    ),
    "screen.missing": (
        "error",
        to_translate(
            "The window needs a display, but DISPLAY is not set. Use the commands instead:"
            " vomstudio --help lists them."
        ),
    ),
    "screen.unreachable": (
        "error",
        to_translate(
            "The display {display} is not available. Check DISPLAY, or use the commands:"
            " vomstudio --help lists them."
        ),
    ),
    "screen.library-failed": (
        "error",
        to_translate("The window libraries cannot be loaded: {error}. Install them again."),
    ),
    "screen.no-opengl": (
        "error",
        to_translate(
            "This display has no OpenGL, so models cannot be drawn. Install the graphics driver, or"
            " on Linux the package libgl1-mesa-dri."
        ),
    ),
    "screen.old-opengl": (
        "error",
        to_translate(
            "This display has OpenGL {version}, but {needed} is required. Update the graphics"
            " driver, or on Linux set LIBGL_ALWAYS_SOFTWARE=1."
        ),
    ),
    "program.repeated": (
        "info",
        *to_translate_n("This has happened {count} time.", "This has happened {count} times."),
    ),
    "program.report-written": (
        "info",
        to_translate("The report was saved as {file}. Read it before sharing it."),
    ),
    "program.memory-full": (
        "error",
        to_translate("The memory is full. Close other programs and try again."),
    ),
    "program.library-missing": (
        "error",
        to_translate(
            "The system library {library} is missing or damaged. Install the package that"
            " contains it."
        ),
    ),
    "plugin.not-defined": (
        "error",
        to_translate("{module} does not define {name}. Add it."),
    ),
    "plugin.not-loaded": (
        "error",
        to_translate("{plugin} cannot be loaded: {reason}. Update or remove its package."),
    ),
    "plugin.other-kind": (
        "error",
        to_translate("{plugin} is not a {kind}. Update or remove its package."),
    ),
    "program.package-missing": (
        "error",
        to_translate(
            "The system library {library} is missing or damaged. Install it (on Debian and"
            " Ubuntu: sudo apt install {package})."
        ),
    ),
    "program.crashed": (
        "error",
        to_translate(
            "The program crashed in the last session. Your work is saved in the journal. Please"
            " save a report, so that the error can be fixed."
        ),
    ),
}
