"""Pages, tables and displays as HTML that needs neither a network nor libraries."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import Any

SCRIPTS = ("shaders.js", "camera.js", "drawing.js", "controls.js", "display.js", "page.js")


def display_html(display: dict[str, Any], still: bytes | None = None) -> str:
    """Return the markup of one display (`data.display`); the page needs `viewer_style` and `viewer_script` once.

    Parameters
    ----------
    still : bytes, optional
        A PNG file (`still.still_picture`), shown where a browser cannot draw the display, or has not drawn it yet.
    """
    data = json.dumps(display, separators=(",", ":")).replace("<", "\\u003c")  # or a name could end the script
    script = f'<script type="application/json">{data}</script>'
    return f'<div class="display">{script}<div class="display-still">{still_html(display, still)}</div></div>'


def still_html(display: dict[str, Any], still: bytes | None) -> str:
    """Return the replacement of a display: a picture, and the notes and tables of its panels as they are at first."""
    parts = [] if still is None else [image_html(display["name"], still)]
    for panel in display["panels"]:
        for layer in panel["layers"]:
            if layer["radius"] == display["radius"]:
                note = f'<p class="display-note">{escape(layer["note"])}</p>'
                parts.append(f"<h3>{escape(panel['title'])}</h3>{note}{layer['details']}")
    return "".join(parts)


def image_html(alt: str, png: bytes) -> str:
    """Return an image element with the bytes of a picture in it."""
    return f'<img alt="{escape(alt)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def viewer_style(*, dark: bool = False) -> str:
    """Return the style of displays.

    Parameters
    ----------
    dark : bool
        Whether the page is dark for readers who prefer that.
    """
    return "\n".join(viewer_file(name) for name in ("viewer.css", "dark.css")[: 1 + dark])


def viewer_script() -> str:
    """Return the program that draws every display of a page."""
    return "\n".join(viewer_file(name) for name in SCRIPTS)


def viewer_file(name: str, package: str = __package__) -> str:
    """Return the text of a file of the viewer, or of another package that draws with it."""
    return (files(package) / name).read_text(encoding="utf-8")


def page_html(title: str, parts: Iterable[str], *, style: str, script: str = "", kind: str = "") -> str:
    """Return a complete page that needs no other files and no network.

    Parameters
    ----------
    title : str
        Plain text.
    parts : iterable of str
        HTML, in order.
    style, script : str
        CSS, and a program that runs after all parts, in a scope of its own.
    kind : str
        Class of the page's body.
    """
    head = '<meta charset="utf-8">\n<meta name="viewport" content="width=device-width, initial-scale=1">\n'
    head += f'<link rel="icon" href="data:,">\n<title>{escape(title)}</title>\n<style>\n{style}</style>'
    program = f"<script>\n(() => {{\n{script}\n}})();\n</script>\n" if script else ""
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n{head}\n</head>\n'
        f"<body{attribute('class', kind)}>\n{body}\n{program}</body>\n</html>\n"
    )


def display_page(title: str, parts: Iterable[str]) -> str:
    """Return a complete page of displays and other markup; see `page_html`."""
    return page_html(title, parts, style=viewer_style(dark=True), script=viewer_script(), kind="display-page")


def table_html(
    head: Sequence[str], rows: Iterable[Sequence[str]], *, texts: int | None = 1, kind: str = "", label: str = ""
) -> str:
    """Return a table, which scrolls if it is wider than the page.

    Parameters
    ----------
    head, rows
        Plain text.
    texts : int
        Number of columns from the left that are words; the others are numbers. None: all columns are words.
    kind : str
        Class of the table.
    label : str
        Description of the table for readers who cannot see it.
    """
    lines = "\n".join(row_html("td", row, texts) for row in rows)
    return (
        f'<div class="scroll"><table{attribute("class", kind)}{attribute("aria-label", label)}>'
        f"{row_html('th', head, texts)}\n{lines}</table></div>"
    )


def row_html(kind: str, cells: Sequence[str], texts: int | None) -> str:
    """Return a row of cells of a kind, ``th`` or ``td``; see `table_html`."""
    words, numbers = cells[:texts], cells[len(cells) if texts is None else texts :]
    parts = [f"<{kind}>{escape(cell)}</{kind}>" for cell in words]
    parts += [f'<{kind} class="number">{escape(cell)}</{kind}>' for cell in numbers]
    return f"<tr>{''.join(parts)}</tr>"


def attribute(name: str, value: str) -> str:
    """Return an attribute of an element, or nothing without a value."""
    return f' {name}="{escape(value)}"' if value else ""
