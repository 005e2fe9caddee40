"""The old names of what is in `cached_runs`; they will be removed in the next version."""

from typing import Any

from ..errors import warn_renamed
from . import cached_runs

NEW_NAMES = {"Dropping": "DropConfig", "Loading": "LoadOptions", "KeptFile": "CachedFile"}


def __getattr__(name: str) -> Any:
    new = NEW_NAMES.get(name, name)
    value = getattr(cached_runs, new)
    warn_renamed(f"settling.dropping.{name}", f"settling.cached_runs.{new}")
    return value
