"""Parts of self-contained HTML pages."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

_STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 66em; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { margin-bottom: .1em; } h2 { margin-top: 1.6em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: .6em 0; }
td, th { padding: .15em 1em .15em 0; text-align: left; border-bottom: 1px solid #e4e4e4; }
td { font-variant-numeric: tabular-nums; vertical-align: top; } tr.out td { background: #fbe9d0; }
.note { background: #fff6e0; border-left: 4px solid #e69f00; padding: .3em .8em; margin: .4em 0; }
.figure { margin: 24px 0 0 0; } img { max-width: 100%; } .small { color: #666; font-size: 13px; }
@media print {
  body { font-size: 11px; max-width: none; margin: 0; padding: 0; } .small { font-size: 10px; }
  td, th { padding-right: .7em; } td:last-child { min-width: 16em; }
  tr, img { break-inside: avoid; } h2 { break-after: avoid; }
}
"""


def html_page(title: str, body: str) -> str:
    """Return the HTML of a complete page.

    Parameters
    ----------
    title : str
    body : str
        HTML of the page below its title.

    Returns
    -------
    str
    """
    name = escape(title)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{name}</title><style>{_STYLE}</style></head>"
        f"<body><h1>{name}</h1>{body}</body></html>\n"
    )


def heading(text: str, level: int = 2) -> str:
    """Return the HTML of a heading.

    Parameters
    ----------
    text : str
    level : int, optional
        2 for a section, 3 for a subsection.

    Returns
    -------
    str
    """
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str, kind: str = "") -> str:
    """Return the HTML of a paragraph.

    Parameters
    ----------
    text : str
    kind : {"", "note", "small"}, optional

    Returns
    -------
    str
    """
    attribute = f' class="{kind}"' if kind else ""
    return f"<p{attribute}>{escape(text)}</p>"


def table(head: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """Return the HTML of a table.

    Parameters
    ----------
    head : sequence of str
        Titles of the columns.
    rows : sequence of tuple
        Class and cells of each row; the class "out" highlights a row.

    Returns
    -------
    str
    """
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = "\n".join(
        f'<tr class="{kind}">' + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>"
        for kind, row in rows
    )
    return f"<table><tr>{cells}</tr>\n{lines}</table>"


def number(value: float | None, digits: int, unit: str = "") -> str:
    """Return a number with its unit, or a dash if it is unknown.

    Parameters
    ----------
    value : float or None
    digits : int
        Number of decimals.
    unit : str, optional

    Returns
    -------
    str
    """
    if value is None or value != value:
        return "–"
    # Adding 0.0 removes the sign of values that round to zero.
    return f"{round(value, digits) + 0.0:,.{digits}f}{unit}"


def svg_picture(svg: bytes, caption: str) -> str:
    """Return the HTML of an embedded SVG picture with its caption.

    Parameters
    ----------
    svg : bytes
    caption : str

    Returns
    -------
    str
    """
    data = base64.b64encode(svg).decode("ascii")
    image = f'<img src="data:image/svg+xml;base64,{data}" alt="{escape(caption)}">'
    return f'<p class="figure">{image}</p>' + paragraph(caption, "small")
