"""Pieces of HTML that carry everything with them, so that a page needs nothing beside it, not even a network."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Sequence
from html import escape

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1c1c22; background: #fff;
  margin: 0 auto; padding: 1rem 1.5rem; max-width: 1120px; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 1rem 0 .5rem; }
h2 { font-size: 1.35rem; margin: 2.2rem 0 .4rem; border-top: 1px solid #d8d8de; padding-top: 1.2rem; }
h3 { font-size: 1.05rem; margin: .5rem 0; }
p { max-width: 56rem; margin: .5rem 0; }
.lead { font-size: 1.15rem; max-width: none; }
.note { color: #55555f; font-size: .9rem; }
img { max-width: 100%; height: auto; border-radius: 6px; background: #f3f3f6; }
.groups { display: grid; grid-template-columns: repeat(auto-fit, minmax(330px, 1fr)); gap: .5rem 2rem; margin: 1rem 0; }
.bar { display: grid; grid-template-columns: 9.5rem 1fr 2.5rem; gap: .5rem; align-items: center;
  font-size: .88rem; line-height: 1.25; margin: .3rem 0; }
.track { background: #ececf0; height: 1rem; }
.fill { display: block; height: 100%; }
.fill.spheres { background: #0b4f8a; }
.fill.baseline { background: repeating-linear-gradient(45deg, #a9a9b4 0 4px, #c4c4cd 4px 8px); }
.number { font-variant-numeric: tabular-nums; text-align: right; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .95rem; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid #b8b8c2; }
th, td { padding: .25rem 1.1rem .25rem 0; vertical-align: top; }
td { border-bottom: 1px solid #e6e6ea; }
.numbers :is(td, th):not(:first-child) { text-align: right; font-variant-numeric: tabular-nums;
  padding: .25rem 0 .25rem 1.6rem; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(230px, 1fr)); gap: 1.5rem; margin-top: 1rem; }
.cards p { font-size: .92rem; }
.cards .note { font-size: .82rem; }
.scores { font-size: .88rem; width: 100%; margin: .3rem 0; }
.scores th:nth-child(2) { text-align: right; }
.verdict { font-size: .85rem; font-weight: 600; border-radius: 4px; padding: .05rem .45rem; margin-left: .3rem; }
.verdict.right { background: #e3eef8; color: #0b4f8a; }
.verdict.wrong { background: #7a3b00; color: #fff; }
.drawing { width: 100%; background: none; border-radius: 0; }
.columns .drawing { width: min(100%, 560px); }
.columns p { flex: 1 1 18rem; max-width: 30rem; }
.label { font-weight: 400; color: #55555f; }
.advice td:nth-child(2) { font-weight: 600; }
article { margin-top: 1.6rem; }
details { margin: .6rem 0; }
summary { cursor: pointer; }
pre { background: #f3f3f6; padding: .7rem 1rem; font-size: .85rem; overflow-x: auto; border-radius: 6px; }
.columns { display: flex; flex-wrap: wrap; gap: 1rem 4rem; align-items: flex-start; }
"""


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
