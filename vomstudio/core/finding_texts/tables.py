"""Texts of the findings about tables."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "table.no-rows": (
        "error",
        to_translate("The table has no rows. Add rows below the header."),
    ),
    "table.commented-rows": (
        "warning",
        *to_translate_n(
            "Line {lines} begins with # and was skipped as a comment, but looks like a row. If"
            " so, remove the #.",
            "Lines {lines} begin with # and were skipped as comments, but look like rows. If so,"
            " remove the #.",
        ),
    ),
    "table.too-large": (
        "error",
        to_translate(
            "The text file is too large ({size_gib:.1f} GiB). Convert the points to LAS or PLY"
            " first."
        ),
    ),
    "table.too-many-rows": (
        "error",
        to_translate(
            "The table has {count:,} lines; the limit for this kind of table is {limit:,}. Divide"
            " it, or convert cloud points to LAS or PLY."
        ),
    ),
    "table.long-line": (
        "error",
        to_translate(
            "A line has {count:,} characters, too many for a table. Check that this is the right"
            " file."
        ),
    ),
    "table.ragged-row": (
        "error",
        to_translate(
            "This row has {count} cells instead of {expected} (delimiter: {delimiter}). Complete"
            " or correct it. Numbers with decimal commas need ; between the columns."
        ),
    ),
    "table.open-quotes": (
        "error",
        to_translate(
            "The quotation marks of this row do not match ({reason}). Close or remove them."
        ),
    ),
    "table.column-count": (
        "error",
        to_translate("The table has {count} columns. Required columns: {columns}."),
    ),
    "table.no-header": (
        "error",
        to_translate("The table has no header. Name its columns in the first line: {columns}."),
    ),
    "table.doubtful-header": (
        "error",
        to_translate(
            "Column {column}: line {header_line} was read as the header, because '{cell}' is not a"
            " number. If this line contains data, add a header above it."
        ),
    ),
    "table.missing-column": (
        "error",
        to_translate(
            "The table has no column for {column}. The columns are: {columns}. Rename the matching"
            " column to one of: {names}."
        ),
    ),
    "table.unknown-column": (
        "error",
        to_translate("The table has no column '{column}'. The columns are: {columns}."),
    ),
    "table.repeated-column": (
        "error",
        to_translate("Several columns are '{column}': {columns}. Rename all but one."),
    ),
    "table.value-missing": (
        "error",
        to_translate("The value is missing or invalid. Correct the cell."),
    ),
    "table.not-a-number": (
        "error",
        to_translate("'{cell}' is not a number. Correct or remove the row."),
    ),
    "table.decimal-comma": (
        "error",
        to_translate(
            "'{cell}' has a decimal comma, which needs ; or tabs between the columns. Use decimal"
            " points, or another delimiter."
        ),
    ),
    "table.comma-delimiter": (
        "error",
        to_translate(
            "Decimal commas cannot be distinguished from delimiters here. Use ; or tabs between"
            " the columns, or decimal points."
        ),
    ),
    "table.mixed-decimals": (
        "error",
        to_translate("The column mixes decimal commas and decimal points. Use only one of them."),
    ),
    "table.not-positive": (
        "error",
        to_translate("The value must be positive. Correct it."),
    ),
    "table.unknown-word": (
        "error",
        to_translate("'{cell}' is not valid here. Use one of: {words}."),
    ),
    "table.repeated-label": (
        "error",
        to_translate("'{label}' also occurs in line {first_line}. Rename or remove one of them."),
    ),
    "table.invalid-wkt": (
        "error",
        to_translate(
            "An outline in the column wkt is not a valid geometry. Write it as WKT, or leave the"
            " cell empty."
        ),
    ),
    "table.rows-left-out": (
        "warning",
        *to_translate_n(
            "{count} row without valid {needed} is left out (line {lines}).",
            "{count} rows without valid {needed} are left out (lines {lines}).",
        ),
    ),
    "table.no-valid-rows": (
        "error",
        to_translate("None of the {count} rows has valid {needed}. Fill in the columns."),
    ),
    "table.several-words": (
        "warning",
        to_translate(
            "The points of {names} have more than one {column}, so none is used. Use one value"
            " for all points of a feature."
        ),
    ),
    "table.segments": (
        "warning",
        to_translate(
            "Lines such as '---' divide the rows into {count} parts, but one plane is fitted to"
            " all points. To fit each part, use --by segment."
        ),
    ),
    "table.groups": (
        "warning",
        to_translate(
            "Column '{column}' has {count} different values and may define groups, but one plane"
            " is fitted to all points. To fit each group, use --by {by}."
        ),
    ),
    "table.only-repeats": (
        "error",
        to_translate("All rows repeat picks that are not in the table. Add these picks."),
    ),
    "table.repeats-left-out": (
        "warning",
        *to_translate_n(
            "{count} repeated pick is left out (see vomstudio repeats).",
            "{count} repeated picks are left out (see vomstudio repeats).",
        ),
    ),
    "table.rows-copied": (
        "info",
        *to_translate_n(
            "{count} row has been copied.",
            "{count} rows have been copied.",
        ),
    ),
    "orientation.no-columns": (
        "error",
        to_translate(
            "The header ({columns}) contains no orientation columns. Name the columns strike and"
            " dip, dip direction and dip, or trend and plunge, or use --columns."
        ),
    ),
    "orientation.no-planes": (
        "error",
        to_translate("The table contains no planes. Choose a table of planes."),
    ),
    "orientation.ambiguous-azimuth": (
        "error",
        to_translate(
            "The azimuth may be strike or dip direction. Specify it with --azimuth strike or"
            " --azimuth dipdir, or state the columns, as in --columns {example}."
        ),
    ),
    "orientation.two-conventions": (
        "warning",
        to_translate(
            "{column} mixes two notations: {other_count} cells with letters, and {count} pairs of"
            " numbers, which are read as {notation}."
        ),
    ),
    "orientation.other-axes": (
        "warning",
        to_translate(
            "The lines are the axes {used}; {axes} are not used. Choose another axis with"
            " --columns, such as K3dec=trend,K3inc=plunge."
        ),
    ),
    "columns.invalid": (
        "error",
        to_translate(
            "“{text}” does not state the meaning of a column. Write NAME=MEANING, such as"
            " azi=dip_direction,inc=dip."
        ),
    ),
    "columns.unknown-meaning": (
        "error",
        to_translate("“{meaning}” is not a known meaning. Use one of: {meanings}."),
    ),
    "table.no-layers": (
        "error",
        to_translate("A text table has no layer “{layer}”. Omit --layer."),
    ),
    "table.places-unused": (
        "warning",
        to_translate("The positions of the points are not used: {reason}"),
    ),
    "orientation.overturned-dip": (
        "error",
        to_translate(
            "The dip {value:g} is outside 0 to 90 degrees. Enter {dip:g} with the opposite dip"
            " direction and 'yes' in a column 'overturned', or check the column order."
        ),
    ),
    "orientation.unclear-overturned": (
        "warning",
        to_translate(
            "{column}: '{word}' is neither yes nor no. These beds are read as upright: lines"
            " {lines}."
        ),
    ),
    "orientation.azimuths-wrapped": (
        "warning",
        *to_translate_n(
            "{count} azimuth outside 0 to 360 in {column} is read modulo 360 (line {lines}).",
            "{count} azimuths outside 0 to 360 in {column} are read modulo 360 (lines {lines}).",
        ),
    ),
    "orientation.quadrants-unused": (
        "warning",
        to_translate(
            "Compass directions in {columns} are not used. If they are dip quadrants, name the"
            " column 'quadrant'."
        ),
    ),
    "orientation.strike-left-hand": (
        "warning",
        to_translate(
            "{column} follows the left-hand rule: it is dip direction + 90. The dip direction is"
            " used."
        ),
    ),
    "orientation.strike-differs": (
        "warning",
        *to_translate_n(
            "{column} is not dip direction - 90 in {count} row (line {lines}). The dip direction"
            " is used.",
            "{column} is not dip direction - 90 in {count} rows (lines {lines}). The dip direction"
            " is used.",
        ),
    ),
    "orientation.planes-with-lines": (
        "warning",
        *to_translate_n(
            "{count} row contains a plane and a line and is read as a plane. To choose, add a"
            " column 'element' (plane or line).",
            "{count} rows contain a plane and a line and are read as planes. To choose, add a"
            " column 'element' (plane or line).",
        ),
    ),
    "slip.missing-columns": (
        "error",
        to_translate(
            "The table has no columns for {missing}. Name them in its first row, for example:"
            " {example}."
        ),
    ),
    "slip.numbered-senses": (
        "info",
        to_translate(
            "The senses of slip are read as codes of T-TECTO: 1 reverse, 2 normal, 3 dextral,"
            " 4 sinistral."
        ),
    ),
    "slip.signed-senses": (
        "info",
        to_translate(
            "The senses of slip are read as codes of APSG: 1 hanging wall down (normal), -1 up"
            " (reverse)."
        ),
    ),
    "slip.right-lateral": (
        "warning",
        to_translate(
            "The sense R is read as right-lateral, because T or L occur as in FaultKin's tables."
            " Write TR or reverse for reverse slip."
        ),
    ),
    "slip.off-plane": (
        "warning",
        *to_translate_n(
            "{count} line deviates from its plane by more than {angle_deg:g} degrees (line"
            " {lines}).",
            "{count} lines deviate from their planes by more than {angle_deg:g} degrees (lines"
            " {lines}).",
        ),
    ),
    "slip.contradiction": (
        "error",
        to_translate(
            "'{word}' contradicts the rake {rake_deg:.0f} of the striae on this plane. Correct one"
            " of them."
        ),
    ),
    "table.other-delimiter": (
        "error",
        to_translate("The cells are separated by '{delimiter}'. Separate them by spaces or tabs."),
    ),
    "repeats.no-column": (
        "error",
        to_translate(
            "The table has no column repeat_of. With --by, specify a column whose value is the"
            " same for all picks of a structure."
        ),
    ),
    "table.no-errors": (
        "error",
        to_translate("The table has no errors for weighting. Add one of the columns {columns}."),
    ),
    "repeats.not-exported": (
        "info",
        to_translate("The feature repeats {first}, which this format cannot store."),
    ),
    "feature.without-plane": ("info", to_translate("The feature has neither a plane nor a line.")),
    "repeats.first-missing": (
        "info",
        to_translate("Its first pick, {first}, is not in the table. Add it."),
    ),
    "repeats.line-of-plane": (
        "info",
        to_translate("The repeat is a line, but its first pick is a plane."),
    ),
    "repeats.plane-of-line": (
        "info",
        to_translate("The repeat is a plane, but its first pick is a line."),
    ),
    "repeats.none": (
        "info",
        to_translate("No structure has been picked twice. Repeat some picks."),
    ),
    "repeats.scatter": (
        "info",
        *to_translate_n(
            "{count} repeat: picks scatter by {error_deg:.1f}° (95 %), with a confidence interval"
            " of {low_deg:.1f} to {high_deg:.1f}°.",
            "{count} repeats: picks scatter by {error_deg:.1f}° (95 %), with a confidence interval"
            " of {low_deg:.1f} to {high_deg:.1f}°.",
        ),
    ),
    "repeats.no-errors": ("info", to_translate("The picks have no stated errors for comparison.")),
    "repeats.interpreters-differ": (
        "warning",
        to_translate(
            "Differences between interpreters are significantly larger than between repeats by the"
            " same interpreter (F {ratio:.1f}, p {p:.3f})."
        ),
    ),
    "repeats.interpreters-alike": (
        "info",
        to_translate(
            "Differences between interpreters are not significantly larger than between repeats by"
            " the same interpreter (F {ratio:.1f}, p {p:.2f})."
        ),
    ),
    "repeats.only-picking": (
        "info",
        to_translate(
            "Repeats show only the picking error. The errors of the model and its registration"
            " are the same in both picks."
        ),
    ),
    "repeats.errors-too-small": (
        "warning",
        to_translate(
            "The stated errors are too small: the differences between picks are {factor:.1f} times"
            " as large as predicted (95 %: {low:.1f} to {high:.1f})."
        ),
    ),
    "repeats.too-few": (
        "info",
        *to_translate_n(
            "{count} pair is too few to detect stated errors that are half as large as they"
            " should be. Repeat more picks.",
            "{count} pairs are too few to detect stated errors that are half as large as they"
            " should be. Repeat more picks.",
        ),
    ),
    "repeats.errors-hold": (
        "info",
        to_translate(
            "The stated errors agree with the repeats: differences are {factor:.2f} times as large"
            " as predicted. Errors too small by a factor of {noticeable:.1f} would be detected."
        ),
    ),
    "stats.unnamed-set": (
        "info",
        to_translate("Rows with an empty cell in column “{column}” form the set “{set}”."),
    ),
    "stats.several-kinds": (
        "warning",
        to_translate(
            "The set “{set}” pools several kinds ({kinds}). Use --by to describe them separately."
        ),
    ),
    "stats.planes-and-lines": (
        "info",
        to_translate("The set “{set}” has planes and lines. They are described separately."),
    ),
}
