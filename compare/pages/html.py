"""Reports as HTML, with their pictures inside."""

from __future__ import annotations

import base64
from collections.abc import Callable
from html import escape
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from PIL.Image import Image

from spherefunc_bullet.viewer import page
from spherefunc_bullet.viewer.mechanics_pictures import png_of


def report_page(title: str, body: str, *, displays: bool = False) -> str:
    """Return a page of HTML under a title of plain text, with the viewer's script if it has displays."""
    style = page.viewer_file("report.css", __package__)
    if not displays:
        return page.page_html(title, [body], style=style)
    return page.page_html(title, [body], style=f"{style}\n{page.viewer_style()}", script=page.viewer_script())


def image(picture: Image, alt: str) -> str:
    """Return a picture as an HTML element that carries its own bytes."""
    return page.image_html(alt, png_of(picture))


def drawing(svg: str, alt: str) -> str:
    """Return an SVG as an HTML image, so that names in it cannot conflict with others of the page."""
    data = base64.b64encode(svg.encode()).decode()
    return f'<img class="drawing" alt="{escape(alt)}" src="data:image/svg+xml;base64,{data}">'


def filled_template(package: str, **values: Any) -> str:
    """Return a package's ``page.html`` filled with values, which are escaped as plain text.

    Templates may call `table_html`, `display_html`, `image` and `drawing`, which escape their arguments themselves.
    """
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals |= {
        make.__name__: as_markup(make) for make in (page.table_html, page.display_html, image, drawing)
    }
    return environment.from_string(page.viewer_file("page.html", package)).render(values)


def as_markup(make: Callable[..., str]) -> Callable[..., Markup]:
    """Return a function that makes HTML with its results marked, so that a template does not escape them again."""
    return lambda *arguments, **options: Markup(make(*arguments, **options))
