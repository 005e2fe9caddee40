"""Pieces of HTML that carry everything with them, so that a page needs nothing beside it, not even a network."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Sequence
from html import escape

from .stylesheet import STYLE


def document(title: str, parts: Iterable[str]) -> str:
    """Return a page of parts, which are HTML, under a title, which is plain text."""
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
    head += f'<title>{escape(title)}</title><style>{STYLE}</style>'
    body = "\n".join(parts)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>{body}</body></html>\n'


def table(head: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "numbers") -> str:
    """Return an HTML table, its first column names."""
    top = "".join(f"<th>{escape(text)}</th>" for text in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table class="{kind}"><tr>{top}</tr>{body}</table></div>'


def image(picture, alt: str) -> str:
    """Return a picture as an HTML element that carries its own bytes."""
    buffer = io.BytesIO()
    picture.quantize(192).save(buffer, "png", optimize=True)
    data = base64.b64encode(buffer.getvalue()).decode()
    size = f'width="{picture.width}" height="{picture.height}"'
    return f'<img alt="{escape(alt)}" {size} src="data:image/png;base64,{data}">'


def drawing(svg: str, alt: str) -> str:
    """Return an SVG as an HTML element; as an image, so that names within it meet no others of the page."""
    data = base64.b64encode(svg.encode()).decode()
    return f'<img class="drawing" alt="{escape(alt)}" src="data:image/svg+xml;base64,{data}">'
