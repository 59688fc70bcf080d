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
            "Line {lines} begins with # and is taken as a comment, but looks like a row. If it is"
            " one, remove the #.",
            "Lines {lines} begin with # and are taken as comments, but look like rows. If they"
            " are, remove the #.",
        ),
    ),
    "table.too-large": (
        "error",
        to_translate(
            "The text has {size_gib:.1f} GiB. Convert so many points to LAS or PLY first."
        ),
    ),
    "table.too-many-rows": (
        "error",
        to_translate(
            "The table has {count:,} lines; {limit:,} of its kind can be read. Divide it, or"
            " convert points of a cloud to LAS or PLY."
        ),
    ),
    "table.long-line": (
        "error",
        to_translate(
            "A line has {count:,} characters, more than any table has. Check what the file is."
        ),
    ),
    "table.ragged-row": (
        "error",
        to_translate(
            "This row has {count} cells, not {expected} (delimiter: {delimiter}). Complete or"
            " correct it. Numbers with decimal commas need ; between the columns."
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
        to_translate("The table has {count} columns. Needed are: {columns}."),
    ),
    "table.no-header": (
        "error",
        to_translate("The table has no header. Name its columns in the first line: {columns}."),
    ),
    "table.doubtful-header": (
        "error",
        to_translate(
            "Column {column}: line {header_line} was taken as the header because its cell '{cell}'"
            " is not a number. If it is data, write a header above it."
        ),
    ),
    "table.missing-column": (
        "error",
        to_translate(
            "The table has no column for {column}. The columns are: {columns}. Name one of them:"
            " {names}."
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
        to_translate("The value is missing or not valid. Correct the cell."),
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
            "Decimal commas cannot be distinguished from delimiters here. Write ; or tabs between"
            " the columns, or decimal points."
        ),
    ),
    "table.mixed-decimals": (
        "error",
        to_translate(
            "Decimal commas and decimal points are mixed in this column. Use one of them."
        ),
    ),
    "table.not-positive": (
        "error",
        to_translate("The value must be positive. Correct it."),
    ),
    "table.unknown-word": (
        "error",
        to_translate("'{cell}' is not one of: {words}. Correct it."),
    ),
    "table.repeated-label": (
        "error",
        to_translate("'{label}' is also in line {first_line}. Rename or remove one of them."),
    ),
    "table.invalid-wkt": (
        "error",
        to_translate(
            "A border in the column wkt is not a valid geometry. Write it as WKT, or leave it"
            " empty."
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
            "The points of {names} have more than one {column}, so none is used. Give all points of"
            " one feature the same."
        ),
    ),
    "table.segments": (
        "warning",
        to_translate(
            "Lines such as '---' divide the rows into {count} parts. All points are taken as one"
            " plane: use --by segment to fit each part."
        ),
    ),
    "table.groups": (
        "warning",
        to_translate(
            "Column '{column}' has {count} different values and looks like groups. All points are"
            " taken as one plane: use --by {by} to fit each."
        ),
    ),
    "table.only-repeats": (
        "error",
        to_translate("All rows repeat picks of other rows, which are not in the table. Add those."),
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
            "Copied {count} row of the table.",
            "Copied {count} rows of the table.",
        ),
    ),
    "orientation.no-columns": (
        "error",
        to_translate(
            "The header ({columns}) has no orientations. Name its columns strike and dip, dip"
            " direction and dip, or trend and plunge."
        ),
    ),
    "orientation.no-planes": (
        "error",
        to_translate("The table has no planes. Choose a table of planes."),
    ),
    "orientation.ambiguous-azimuth": (
        "error",
        to_translate(
            "The azimuth can be strike or dip direction. State which with --azimuth strike or"
            " --azimuth dipdir, or name the column."
        ),
    ),
    "orientation.overturned-dip": (
        "error",
        to_translate(
            "The dip {value:g} is outside 0 to 90 degrees. Write {dip:g} to the opposite side, with"
            " 'yes' in a column 'overturned'; or check the order of columns."
        ),
    ),
    "orientation.unclear-overturned": (
        "warning",
        to_translate(
            "{column}: '{word}' is neither yes nor no. These beds are taken as upright: lines"
            " {lines}."
        ),
    ),
    "orientation.azimuths-wrapped": (
        "warning",
        *to_translate_n(
            "{count} azimuth outside 0 to 360 in {column} is taken modulo 360 (line {lines}).",
            "{count} azimuths outside 0 to 360 in {column} are taken modulo 360 (lines {lines}).",
        ),
    ),
    "orientation.quadrants-unused": (
        "warning",
        to_translate(
            "Compass points in {columns} are not used. If the planes dip to them, name the column"
            " 'quadrant'."
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
        to_translate(
            "{count} rows have a plane and a line and are taken as planes. Add a column 'element'"
            " (plane or line) to choose."
        ),
    ),
    "slip.missing-columns": (
        "error",
        to_translate(
            "The table has no columns for {missing}. Name them in its first row, for example:"
            " {example}."
        ),
    ),
    "slip.right-lateral": (
        "warning",
        to_translate(
            "The sense R is read as right-lateral, since T or L occur as in FaultKin's tables."
            " Write TR or reverse for a reverse movement."
        ),
    ),
    "slip.off-plane": (
        "warning",
        *to_translate_n(
            "{count} line leaves its plane by more than {angle_deg:g} degrees (line {lines}).",
            "{count} lines leave their planes by more than {angle_deg:g} degrees (lines {lines}).",
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
        to_translate("The cells are separated by '{delimiter}'. Separate them by blanks or tabs."),
    ),
    "repeats.no-column": (
        "error",
        to_translate(
            "The table has no column repeat_of. Name with --by a column whose words are equal"
            " for picks of the same structure."
        ),
    ),
    "table.no-errors": (
        "error",
        to_translate("The table has no errors to weight by. Add one of the columns {columns}."),
    ),
    "repeats.not-exported": (
        "info",
        to_translate("It repeats {first}, and this format has no repeats."),
    ),
    "feature.without-plane": ("info", to_translate("It has no plane and no line.")),
    "repeats.first-missing": (
        "info",
        to_translate("The pick {first} that it repeats is not in the table. Add it."),
    ),
    "repeats.line-of-plane": ("info", to_translate("It is a line, and its first pick is a plane.")),
    "repeats.plane-of-line": ("info", to_translate("It is a plane, and its first pick is a line.")),
    "repeats.none": ("info", to_translate("No structure was picked again. Repeat some picks.")),
    "repeats.scatter": (
        "info",
        *to_translate_n(
            "{count} repeat: a pick scatters by {error_deg:.1f}° (95 %), known to be between"
            " {low_deg:.1f} and {high_deg:.1f}°.",
            "{count} repeats: a pick scatters by {error_deg:.1f}° (95 %), known to be between"
            " {low_deg:.1f} and {high_deg:.1f}°.",
        ),
    ),
    "repeats.no-errors": ("info", to_translate("The picks state no errors to compare this with.")),
    "repeats.interpreters-differ": (
        "warning",
        to_translate(
            "Interpreters differ from each other by more than their own repeats do (F"
            " {ratio:.1f}, p {p:.3f})."
        ),
    ),
    "repeats.interpreters-alike": (
        "info",
        to_translate(
            "Interpreters do not differ significantly more than their own repeats do (F"
            " {ratio:.1f}, p {p:.2f})."
        ),
    ),
    "repeats.only-picking": (
        "info",
        to_translate(
            "Repeats show only the errors of picking. The errors of the model and its"
            " registration are the same in both picks."
        ),
    ),
    "repeats.errors-too-small": (
        "warning",
        to_translate(
            "The stated errors are too small: picks differ {factor:.1f} times as much as they"
            " allow (95 %: {low:.1f} to {high:.1f} times)."
        ),
    ),
    "repeats.too-few": (
        "info",
        *to_translate_n(
            "{count} pair is too few to notice stated errors that are half as large as they"
            " should be. Repeat more picks.",
            "{count} pairs are too few to notice stated errors that are half as large as they"
            " should be. Repeat more picks.",
        ),
    ),
    "repeats.errors-hold": (
        "info",
        to_translate(
            "The stated errors fit the repeats: picks differ {factor:.2f} times as much as the"
            " errors allow. Errors too small by {noticeable:.1f} times would be noticed."
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
