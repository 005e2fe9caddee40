"""What ``spherefunc classify`` says of a file that is one view of an object, on which spheres find no hold."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..learning.reasons.one_view import COMPLETED, NOTHING, nothing_settled, settled_on_completed

if TYPE_CHECKING:
    from ..learning.function_model import FunctionModel
    from ..settling.records import Dropping
    from ..settling.settling import Settled

Row = dict[str, Any]  # what the contract prints of one file


def told_as_view(
    row: Row,
    settled: Settled,
    dropping: Dropping,
    scored: Callable[..., Row],
    of_views: Callable[[], FunctionModel],
) -> Row:
    """Return the row of a file that is for nothing and looks like one view, or that of the object completed.

    Parameters
    ----------
    scored : callable
        Takes the file, where spheres settled, the seconds and the model; returns the row.
    of_views : callable
        Returns the model for single views.
    """
    file, lost, model = Path(row["file"]), nothing_settled(settled), of_views()
    completed = settled_on_completed(dropping.cloud(file), model)
    if completed is not None:
        whole = scored(file, completed, row["seconds"], model)
        if lost or any(told["member"] for told in whole["functions"].values()):
            return whole | {"unsure": True, "reasons": [*whole["reasons"], COMPLETED]}
    return row | {"unsure": True, "reasons": [*row["reasons"], NOTHING]} if lost else row
