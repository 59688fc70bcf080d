"""Texts of the findings about jobs, failures, their worker processes and clusters."""

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
        to_translate("There is not enough memory for this. {remedy}"),
    ),
    "job.closing": (
        "error",
        to_translate("The program is closing. No new work is started."),
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
        to_translate("The field '{name}' is {type}, which cannot be sent to another process."),
    ),
    "job.wrong-value": (
        "error",
        to_translate("The field '{name}' should be {type}, but is {value}."),
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
        to_translate("A cluster needs Dask. Install it with: pip install 'vomstudio[cluster]'."),
    ),
    "cluster.no-scheduler": (
        "error",
        to_translate(
            "No Dask scheduler answers at {address}. Start one, or leave this option out."
        ),
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
            "The cluster lost the same part of the work {tries} times ({error}), probably "
            "out of memory. Finished results are kept. Try again."
        ),
    ),
    "edges.network-unused": (
        "error",
        to_translate(
            'A network is used with the cost "onnx" only. Choose this cost, or leave the '
            "network out."
        ),
    ),
    "edges.no-network": (
        "error",
        to_translate('The cost "onnx" needs a network. Give its file with {option}.'),
    ),
    "cost.needs-way-points": (
        "error",
        to_translate(
            'The cost "{cost}" needs way-points. Propose lines by gradient, curvature, dark, light'
            " or a field."
        ),
    ),
    "job.internal-error": (
        "error",
        to_translate(
            "{job}: an internal error occurred ({error}). Your project is unchanged. Please"
            " save a report, so that the fault can be found."
        ),
    ),
    "program.internal-error": (
        "error",
        to_translate(
            "An internal error occurred ({error}). Only your last action may be missing. "
            "Please save a report, so that the fault can be found."
        ),
    ),
    "screen.missing": (
        "error",
        to_translate(
            "There is no screen for the window (DISPLAY is not set). Use the commands instead:"
            " vomstudio --help lists them."
        ),
    ),
    "screen.unreachable": (
        "error",
        to_translate(
            "The screen {display} cannot be reached. Check DISPLAY, or use the commands: vomstudio"
            " --help lists them."
        ),
    ),
    "screen.library-failed": (
        "error",
        to_translate("The libraries of the window cannot be loaded: {error}. Install them again."),
    ),
    "screen.no-opengl": (
        "error",
        to_translate(
            "This screen has no OpenGL, so the window cannot draw. Install the graphics driver, or"
            " on Linux the package libgl1-mesa-dri."
        ),
    ),
    "screen.old-opengl": (
        "error",
        to_translate(
            "This screen has OpenGL {version}, but drawing needs {needed}. Update the graphics"
            " driver, or on Linux set LIBGL_ALWAYS_SOFTWARE=1."
        ),
    ),
    "program.repeated": (
        "info",
        *to_translate_n("It has happened {count} time.", "It has happened {count} times."),
    ),
    "program.report-written": (
        "info",
        to_translate("The report was written to {file}. Read it before you pass it on."),
    ),
    "program.memory-full": (
        "error",
        to_translate("Memory is full. Close other programs and try again."),
    ),
    "program.library-missing": (
        "error",
        to_translate(
            "The system's library {library} is missing or damaged. Install the package that"
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
            "The system's library {library} is missing or damaged. Install it (on Debian "
            "and Ubuntu: sudo apt install {package})."
        ),
    ),
    "program.crashed": (
        "error",
        to_translate(
            "The program crashed when it last ran. Your work is in the journal. Please save "
            "a report, so that the fault can be found."
        ),
    ),
}
