"""Texts of the findings about the placement of models and the values entered for it."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "number.not-an-angle": (
        "error",
        to_translate("“{text}” is not a valid angle in degrees. Correct it."),
    ),
    "number.not-a-length": (
        "error",
        to_translate("“{text}” is not a length in metres. Correct it."),
    ),
    "line.not-seven-numbers": (
        "error",
        to_translate(
            "“{text}” does not consist of seven numbers x1,y1,z1,x2,y2,z2,value. An optional"
            " eighth is the error of the value (one sigma)."
        ),
    ),
    "line.not-six-numbers": (
        "error",
        to_translate(
            "“{text}” does not consist of six numbers x1,y1,z1,x2,y2,z2. An optional seventh is"
            " the error of the line in degrees."
        ),
    ),
    "option.needs-model": (
        "error",
        to_translate("{option} needs a model. Specify its file instead of -."),
    ),
    "option.needs-cameras": (
        "error",
        to_translate(
            "Photos need the cameras of the model. Specify the model instead of -, or its cameras"
            " with --model-cameras."
        ),
    ),
    "option.not-with-project": (
        "error",
        to_translate("The project already defines the positions of its models. Omit this option."),
    ),
    "registration.undetermined": (
        "error",
        to_translate("The reference does not determine {parameters}. Add points that do."),
    ),
    "reference.mask-elsewhere": (
        "error",
        to_translate(
            "The mask contains no point of the reference. Check that both have the same frame."
        ),
    ),
    "reading.points-up": (
        "error",
        to_translate("“{text}” plunges upward. Enter the end of the line that plunges down."),
    ),
    "reading.invalid-error": (
        "error",
        to_translate(
            "“{text}” is not a valid error of a reading. Enter degrees (one sigma), such as 3."
        ),
    ),
    "north.no-convergence": (
        "error",
        to_translate(
            "The convergence between true and grid north is unknown. Enter the position of the"
            " readings."
        ),
    ),
    "photo.none-of-cameras": (
        "error",
        to_translate(
            "None of the photos in the camera file was found ({name}, …). Specify their folder, or"
            " a table of positions or attitudes."
        ),
    ),
}
