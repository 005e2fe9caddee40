"""What to use for which function: the cheapest simulator, unless something else is significantly better.

The sentence on top of the page, the table below it and the words next to the charts all follow `recommendations`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from spherefunc_bullet.formats.units import format_duration
from spherefunc_bullet.viewer.page import table_html

from .significance import (
    BETTER,
    UNKNOWN,
    Difference,
    Report,
    beside_cheapest,
    enumeration,
    leaves_open,
    paired_difference,
    unseen,
    verdict_word,
    with_margin,
)
from .tables import with_spread

THOUSAND = 1000  # objects, for a price that can be imagined


@dataclass(frozen=True, kw_only=True)
class Recommendation:
    """What to use for one function, and why."""

    function: str
    backend: str
    f_measure: float
    reason: str
    baseline: str  # the best one without spheres
    baseline_f: float
    beside: Difference  # the baseline's F-measures less the simulator's
    undecided: bool = False  # whether there are too few objects to decide if another simulator is better

    @property
    def beaten(self) -> bool:
        """Whether the best baseline is better, by the rule for two simulators."""
        return self.beside["verdict"] == BETTER

    @property
    def use(self) -> str:
        """The simulator or baseline to use."""
        return self.baseline if self.beaten else self.backend


def recommendations(report: Report) -> list[Recommendation]:
    """Return what to use for each function.

    It is the cheapest simulator, unless another classifies the function better over the same trials; or the best
    baseline without spheres, if that is better still.
    """
    cheap, others = beside_cheapest(report)
    return [recommended(report, function, cheap, others) for function in report["functions"]]


def recommended(
    report: Report, function: str, cheap: str, differences: Mapping[str, Mapping[str, Difference]]
) -> Recommendation:
    """Return what to use for one function, given how the others differ from the cheapest."""

    def f_of(feature: Report) -> float:
        return feature["functions"][function]["f_measure"]

    baselines, others = report["baselines"], {name: rows[function] for name, rows in differences.items()}
    better = [name for name, row in others.items() if row["verdict"] == BETTER]
    chosen = max(better, key=lambda name: others[name]["difference"], default=cheap)
    baseline = max(baselines, key=lambda name: f_of(baselines[name]))
    trials = [of["functions"][function]["f_measures"] for of in (report["backends"][chosen], baselines[baseline])]
    return Recommendation(
        function=function,
        backend=chosen,
        f_measure=f_of(report["backends"][chosen]),
        reason=reason(chosen, cheap, others),
        baseline=baseline,
        baseline_f=f_of(baselines[baseline]),
        beside=paired_difference(*trials, report["train_size"], report["test_size"]),
        undecided=chosen == cheap and any(leaves_open(row) for row in others.values()),
    )


def reason(chosen: str, cheap: str, others: Mapping[str, Difference]) -> str:
    """Return why a backend is chosen for a function."""
    if not others:
        return "the only one compared"
    if chosen != cheap:
        return f"better than {cheap} ({with_margin(others[chosen])})"
    return "; ".join(f"{name}: slower, {difference_words(row)}" for name, row in others.items())


def difference_words(row: Difference) -> str:
    """Return a difference in words."""
    if row["verdict"] == UNKNOWN:
        return f"differs by {row['difference']:+.3f} in one trial, too few to tell"
    return unseen(row["margin"]) if leaves_open(row) else f"{row['verdict']} ({with_margin(row)})"


def recommendation_sentence(rows: Sequence[Recommendation]) -> str:
    """Return in one sentence what to use for which function, and where that is undecided."""
    by: dict[str, list[str]] = {}
    for row in rows:
        if not row.beaten and not row.undecided:
            by.setdefault(row.backend, []).append(row.function)
    uses = ", and ".join(f"{name} for {enumeration(functions)}" for name, functions in by.items())
    parts = [f"use {uses}"] if by else []
    parts += [f"for {row.function} {without_spheres(row)}" for row in rows if row.beaten]
    undecided = [row for row in rows if row.undecided and not row.beaten]
    if undecided:
        functions = enumeration([row.function for row in undecided])
        parts.append(f"for {functions} there are too few objects to decide; {undecided[0].backend} is the cheapest")
    sentence = "; ".join(parts)
    return f"{sentence[:1].upper()}{sentence[1:]}."


def without_spheres(row: Recommendation) -> str:
    """Return in words which baseline is better than spheres, and by how much."""
    figures = f"F {row.baseline_f:.2f} beside {row.f_measure:.2f} by {row.backend}, {with_margin(row.beside)}"
    return f"{row.baseline.replace('_', ' ')}, without spheres, is better ({figures})"


def recommendation_table(report: Report, chosen: Sequence[Recommendation]) -> str:
    """Return an HTML table of what to use for which function, with all F-measures and the best baseline."""
    backends, rows = report["backends"], []
    for row in chosen:
        use = row.use.replace("_", " ") + (" (undecided)" if row.undecided and not row.beaten else "")
        baseline = f"{row.baseline_f:.3f} ({row.baseline.replace('_', ' ')}, {verdict_word(row.beside)})"
        of_backends = [with_spread(backend["functions"][row.function]) for backend in backends.values()]
        why = without_spheres(row) if row.beaten else row.reason
        rows.append([row.function, use, *of_backends, baseline, why])
    seconds = [format_duration(backend["seconds_per_object"]) for backend in backends.values()]
    head = ["function", "use", *(f"F of {name}" for name in backends), "best without spheres", "why"]
    return table_html(head, [*rows, ["", "median object", *seconds, "", ""]], texts=None, kind="recommendations")


def prices(report: Report) -> dict[str, str]:
    """Return the time that each backend takes for a thousand such objects, on one core."""
    seconds = {name: row["seconds_total"] for name, row in report["backends"].items()}
    return {name: format_duration(THOUSAND * total / report["objects"]) for name, total in seconds.items()}
