"""Scenes as HTML: interactive pictures without network or libraries, in a page of their own or within another."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files

SCRIPTS = ("shaders.js", "camera.js", "drawing.js", "controls.js", "scene.js", "page.js")


def scene_html(scene: dict) -> str:
    """Return the markup of one scene (`scene_data.scene`); the page needs `viewer_html` once, after all scenes."""
    data = json.dumps(scene, separators=(",", ":")).replace("<", "\\u003c")  # or a name could end the script
    return f'<div class="scene"><script type="application/json">{data}</script></div>'


def viewer_html(*, dark: bool = False) -> str:
    """Return the style and the program that draw every scene of a page.

    Parameters
    ----------
    dark : bool
        Whether the page follows a reader who prefers dark ones.
    """
    styles = "\n".join(viewer_file(name) for name in ("viewer.css", "dark.css")[: 1 + dark])
    script = "\n".join(viewer_file(name) for name in SCRIPTS)
    return f"<style>\n{styles}</style>\n<script>\n(() => {{\n{script}\n}})();\n</script>"


def viewer_file(name: str, package: str = __package__) -> str:
    """Return the text of a file of the viewer, or of another package that draws with it."""
    return (files(package) / name).read_text(encoding="utf-8")


def page_html(title: str, parts: Sequence[str]) -> str:
    """Return a whole page of scenes and other markup.

    Parameters
    ----------
    title : str
        Plain text.
    parts : sequence of str
        HTML, in order.
    """
    body = "\n".join(parts)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n</head>\n"
        f'<body class="scene-page">\n{body}\n{viewer_html(dark=True)}\n</body>\n</html>\n'
    )
