"""Which simulator to use for which function: the cheapest, unless another is better by more than the trials spread."""

from __future__ import annotations

from dataclasses import dataclass

from spherefunc_bullet.quantities import format_duration
from spherefunc_bullet.viewer.page import table_html

from .significance import BETTER, UNKNOWN, listed, paired_differences, spoken
from .tables import with_spread

THOUSAND = 1000  # objects, for a price that can be imagined


@dataclass(frozen=True, kw_only=True)
class Advice:
    """What to use for one function, and why."""

    function: str
    backend: str
    f_measure: float
    reason: str
    baseline: str  # the best of those that need no spheres
    baseline_f: float

    @property
    def ahead(self) -> str:
        """Return which baseline the backend has to be ahead of."""
        return f"{self.baseline_f:.2f} ({self.baseline.replace('_', ' ')})"


def advice(report: dict) -> list[Advice]:
    """Return what to use for each function, from a report as `spherefunc compare` writes it.

    The cheapest simulator stands, unless another tells the function better over the same trials (`verdict`).
    """
    backends = report["backends"]
    cheap = min(backends, key=lambda name: backends[name]["seconds_per_object"])
    sizes = report["train_size"], report["test_size"]
    beside = {
        name: paired_differences(backends[cheap]["functions"], backends[name]["functions"], *sizes)
        for name in backends
        if name != cheap
    }
    return [
        advised(report, function, cheap, {name: rows[function] for name, rows in beside.items()})
        for function in report["functions"]
    ]


def advised(report: dict, function: str, cheap: str, beside: dict[str, dict]) -> Advice:
    """Return what to use for one function, given how the others differ from the cheapest there."""
    better = [name for name, row in beside.items() if row["verdict"] == BETTER]
    chosen = max(better, key=lambda name: beside[name]["difference"], default=cheap)
    baseline = max(report["baselines"], key=lambda name: f_of(report["baselines"][name], function))
    return Advice(
        function=function,
        backend=chosen,
        f_measure=f_of(report["backends"][chosen], function),
        reason=reason(chosen, cheap, beside),
        baseline=baseline,
        baseline_f=f_of(report["baselines"][baseline], function),
    )


def reason(chosen: str, cheap: str, beside: dict[str, dict]) -> str:
    """Return why a backend is chosen for a function."""
    if not beside:
        return "the only one compared"
    if chosen != cheap:
        row = beside[chosen]
        return f"better than {cheap} ({row['difference']:+.3f} ± {row['margin']:.3f})"
    return "; ".join(f"{name} is dearer and {held_against(row)}" for name, row in beside.items())


def held_against(row: dict) -> str:
    """Return in words how a dearer backend differs from the cheapest."""
    if row["verdict"] == UNKNOWN:
        return f"differs by {row['difference']:+.3f} in one trial, too few to tell"
    return f"{row['verdict']} ({row['difference']:+.3f} ± {row['margin']:.3f})"


def f_of(features: dict, function: str) -> float:
    """Return one feature's mean F-measure of a function."""
    return features["functions"][function]["f_measure"]


def recommendation(report: dict) -> str:
    """Return the advice as one sentence."""
    by: dict[str, list[str]] = {}
    for each in advice(report):
        by.setdefault(each.backend, []).append(each.function)
    return f"Use {', and '.join(f'{name} for {listed(functions)}' for name, functions in by.items())}."


def advice_table(report: dict) -> str:
    """Return which simulator to use for which function, each one's F-measure, and the best baseline."""
    rows = [
        [
            each.function,
            each.backend,
            *(with_spread(backend["functions"][each.function]) for backend in report["backends"].values()),
            each.ahead,
            each.reason,
        ]
        for each in advice(report)
    ]
    names = [f"F of {name}" for name in report["backends"]]
    times = ["", "median object"] + [spoken(each["seconds_per_object"]) for each in report["backends"].values()]
    head = ["to tell", "use", *names, "best without spheres", "why"]
    return table_html(head, [*rows, [*times, "", ""]], texts=None, kind="advice")


def prices(report: dict) -> dict[str, str]:
    """Return what a thousand such objects take by each backend, on one core."""
    return {
        name: format_duration(THOUSAND * each["seconds_total"] / report["objects"])
        for name, each in report["backends"].items()
    }
