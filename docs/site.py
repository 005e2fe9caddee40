"""What the site takes from elsewhere: the public names from the package, the notebook's cells."""

from __future__ import annotations

import ast
import json
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STUB = ROOT / "spherefunc_bullet" / "__init__.pyi"
NOTEBOOK = ROOT / "docs" / "notebooks" / "from_a_folder_to_a_picture.ipynb"


def on_page_markdown(markdown: str, page, config, files) -> str:
    """Fill in the pages that are made from other files."""
    if page.file.src_uri == "api.md":
        return markdown + "".join(f"\n::: {as_it_lies(name)}\n" for name in public_names())
    if page.file.src_uri == "notebook.md":
        return markdown + "\n\n".join(notebook_cells())
    return markdown


def public_names() -> list[str]:
    """Return where each public name is defined, such as ``clouds.cloud.Cloud``, sorted by the name."""
    imports = [node for node in ast.parse(STUB.read_text()).body if isinstance(node, ast.ImportFrom)]
    return sorted((f"{node.module}.{name.name}" for node in imports for name in node.names), key=last_part)


def as_it_lies(name: str) -> str:
    """Return where a name is found in the repository, whose top folders are installed inside the package."""
    return name if (ROOT / name.partition(".")[0]).is_dir() else f"spherefunc_bullet.{name}"


def last_part(name: str) -> str:
    """Return a name without its module, for sorting."""
    return name.rpartition(".")[2].lower()


def notebook_cells() -> list[str]:
    """Return the notebook's cells as Markdown."""
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    texts = [(cell["cell_type"], "".join(cell["source"])) for cell in cells]
    return [text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in texts]
