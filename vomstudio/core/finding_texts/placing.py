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
            "“{text}” is not seven numbers x1,y1,z1,x2,y2,z2,value. An eighth may state the"
            " error of the value (one sigma)."
        ),
    ),
    "line.not-six-numbers": (
        "error",
        to_translate(
            "“{text}” is not six numbers x1,y1,z1,x2,y2,z2. A seventh may state the error "
            "of the line in degrees."
        ),
    ),
    "option.needs-model": (
        "error",
        to_translate("{option} needs a model. Name its file instead of -."),
    ),
    "option.needs-cameras": (
        "error",
        to_translate(
            "Photos need the cameras of the model. Name the model instead of -, or its "
            "cameras with --model-cameras."
        ),
    ),
    "option.not-with-project": (
        "error",
        to_translate("The project places its models. Leave this option out."),
    ),
    "registration.undetermined": (
        "error",
        to_translate(
            "The reference does not determine: {parameters}. Add points that determine it."
        ),
    ),
    "reference.mask-elsewhere": (
        "error",
        to_translate(
            "No point of the reference lies in the mask. Check that both have the same frame."
        ),
    ),
    "reading.points-up": (
        "error",
        to_translate("“{text}” points up. Give the end of the line that plunges down."),
    ),
    "reading.invalid-error": (
        "error",
        to_translate("“{text}” is not an error of a reading. Type degrees (one sigma), such as 3."),
    ),
    "north.no-convergence": (
        "error",
        to_translate(
            "The convergence between true north and grid north is not known. State the "
            "place of the readings."
        ),
    ),
    "photo.none-of-cameras": (
        "error",
        to_translate(
            "No photo of the model's cameras ({name}, …) was found. Name the folder of the "
            "photos, or a table."
        ),
    ),
}
