"""Reports as HTML, and pictures that travel within them."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from html import escape

from spherefunc_bullet.viewer.page import page_html, viewer_file, viewer_script, viewer_style


def report_page(title: str, parts: Iterable[str], *, scenes: bool = False) -> str:
    """Return a page of parts, which are HTML, under a title, which is plain text; with what draws scenes on it."""
    style = viewer_file("report.css", __package__)
    if not scenes:
        return page_html(title, parts, style=style)
    return page_html(title, parts, style=f"{style}\n{viewer_style()}", script=viewer_script())


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
