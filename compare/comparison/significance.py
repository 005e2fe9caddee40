"""Which simulator classifies better, and at what cost: differences between paired trials, and one sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from spherefunc_bullet.formats.units import format_duration

from ..evaluation.evaluation import Qualities
from ..evaluation.impaired import COPIES_LEARNT, mean_shares

Report = Mapping[str, Any]  # the JSON of `spherefunc compare`, see `comparison.compare_entries`
Difference = dict[str, Any]  # see `paired_difference`

BETTER, WORSE, EQUAL, UNKNOWN = "better", "worse", "equal", "unknown"
CONFIDENCE = 0.95
COARSE = 0.1  # a wider margin of F-measures leaves open which simulator is better


def paired_differences(first: Qualities, second: Qualities, train: int, test: int) -> dict[str, Difference]:
    """Return, per function, how much better the second classifies than the first, over the same trials."""
    pairs = {name: (first[name]["f_measures"], second[name]["f_measures"]) for name in first}
    return {name: paired_difference(*pair, train, test) for name, pair in pairs.items()}


def paired_difference(first: Sequence[float], second: Sequence[float], train: int, test: int) -> Difference:
    """Return the mean of second minus first, its margin (None for one trial), and whether the second is better or not.

    The trials share objects, so they are not independent, and an ordinary t-test would find differences by chance, the
    more trials there are. The margin is the half width of the 95 % interval of Nadeau and Bengio's corrected
    resampled t-test ("Inference for the Generalization Error", Machine Learning 52, 2003), which counts the variance
    between trials 1 / trials + test / train times.
    """
    differences = np.subtract(second, first)
    mean = float(differences.mean())
    if len(differences) < 2:
        return {"difference": round(mean, 4), "margin": None, "verdict": UNKNOWN}
    from scipy.stats import t

    error = math.sqrt((1 / len(differences) + test / train) * float(differences.var(ddof=1)))
    margin = float(t.ppf((1 + CONFIDENCE) / 2, len(differences) - 1)) * error
    # F-measures are kept to four places; smaller differences do not count.
    verdict = EQUAL if abs(mean) <= max(margin, 5e-5) else BETTER if mean > 0 else WORSE
    return {"difference": round(mean, 4), "margin": round(margin, 4), "verdict": verdict}


def beside_cheapest(report: Report) -> tuple[str, dict[str, dict[str, Difference]]]:
    """Return the quickest simulator, and how much better each other one classifies each function."""
    backends, sizes = report["backends"], (report["train_size"], report["test_size"])
    cheap, *others = sorted(backends, key=lambda name: backends[name]["seconds_per_object"])
    cheapest = backends[cheap]["functions"]
    return cheap, {name: paired_differences(cheapest, backends[name]["functions"], *sizes) for name in others}


def answer(report: Report) -> str:
    """Return how much better or worse each simulator is than the quickest one, and at what cost.

    Before it, where copies were measured, comes what spheres gain over features without spheres; after it, what
    fidelity gains at other tasks.
    """
    about_copies = f"{benefit_sentence(report)} " if report.get("impaired") else ""
    about_tasks = "".join(f" {task['says'][:1].upper()}{task['says'][1:]}" for task in report.get("tasks", {}).values())
    return f"{about_copies}{about_labels(report)}{about_tasks}"


def benefit_sentence(report: Report) -> str:
    """Return in one sentence whether spheres distinguish copies that work from copies that do not."""
    shares, backends = report["impaired"], list(report["backends"])
    features = list(next(iter(next(iter(shares.values())).values()))["share"])
    useless, works = mean_shares(shares, features).values()
    apart = {name: works[name] - useless[name] for name in features}  # 1 at best
    others = [name for name in features if name.partition(",")[0] not in backends and not name.endswith(COPIES_LEARNT)]
    best = max(others, key=lambda name: apart[name])
    wins = max(apart[name] for name in backends) > apart[best]
    useless_shares = enumeration([f"{useless[name]:.0%} by {name.replace('_', ' ')}" for name in (*backends, best)])
    working_shares = enumeration([f"{works[name]:.0%}" for name in (*backends, best)])
    verb = "distinguish" if wins else "do not better distinguish"
    lead = f"Spheres {verb} copies that work from copies that only look alike"
    return (
        f"{lead}: of copies that no longer work, {useless_shares}, the best baseline without spheres, are still "
        f"classified by their function; of harmlessly changed copies, {working_shares} are."
    )


def about_labels(report: Report) -> str:
    """Return in one sentence how much better the simulators' labels are, and at what cost."""
    (cheap, others), backends = beside_cheapest(report), report["backends"]
    if not others:
        row = backends[cheap]
        figures = enumeration([f"{name} {quality['f_measure']:.2f}" for name, quality in row["functions"].items()])
        price = f"{format_duration(row['seconds_per_object'])} an object"
        return f"{cheap} was compared with no other backend: F-measures of {figures} at {price}."
    prices = {name: price_words(backends[name], backends[cheap]) for name in others}
    parts = [f"{quality_words(name, differences)}, {prices[name]}" for name, differences in others.items()]
    return f"Beside {cheap}, {'; '.join(parts)}."


def quality_words(name: str, differences: Mapping[str, Difference]) -> str:
    """Return in words at which functions a backend is better, worse and as good."""
    by: dict[str, dict[str, Difference]] = {BETTER: {}, WORSE: {}, EQUAL: {}, UNKNOWN: {}}
    for function, row in differences.items():
        by[row["verdict"]][function] = row
    if len(by[UNKNOWN]) == len(differences):
        signed = enumeration([f"{function} by {row['difference']:+.3f}" for function, row in differences.items()])
        return f"{name} differs at {signed} in one trial, too few to tell"
    parts = [
        f"{verdict} at {enumeration([f'{function} (F {with_margin(row)})' for function, row in by[verdict].items()])}"
        for verdict in (BETTER, WORSE)
        if by[verdict]
    ]
    equal = {function: row for function, row in by[EQUAL].items() if row["margin"] <= COARSE}
    open_ = {function: row for function, row in by[EQUAL].items() if row["margin"] > COARSE}
    if equal:
        largest = max(abs(row["difference"]) for row in equal.values())
        within = f"F-measures differ by {largest:.3f} at most, within the spread of the trials"
        parts.append(f"as good at {enumeration(list(equal))} ({within})")
    if open_:
        signed = enumeration([f"{function} ({unseen(row['margin'])})" for function, row in open_.items()])
        parts.append(f"not measurably better or worse, with so few objects, at {signed}")
    return f"{name} is {enumeration(parts)}"


def with_margin(row: Difference) -> str:
    """Return a difference with its margin."""
    return f"{row['difference']:+.3f} ± {row['margin']:.3f}"


def leaves_open(row: Difference) -> bool:
    """Return whether the true difference may be large."""
    return row["verdict"] == UNKNOWN or (row["verdict"] == EQUAL and row["margin"] > COARSE)


def verdict_word(row: Difference) -> str:
    """Return a verdict in a word: it is undecided, not equal, where the true difference may be large."""
    return "undecided" if leaves_open(row) else row["verdict"]


def unseen(margin: float) -> str:
    """Return in words which differences of F-measures, which are from 0 to 1, may be chance with so few objects."""
    return f"F-measures may differ by {margin:.2f} by chance" if margin < 1 else "any difference may be chance"


def price_words(backend: Report, cheaper: Report) -> str:
    """Return in words how many times the time of a cheaper backend a backend takes."""
    longer, shorter = backend["seconds_per_object"], cheaper["seconds_per_object"]
    note = "" if backend["radii"] == cheaper["radii"] else ", each with radii of its own"
    seconds = f"{format_duration(longer)} against {format_duration(shorter)} an object{note}"
    if not shorter > 0:
        return f"at {seconds}"
    return f"at {longer / shorter:.{0 if longer / shorter >= 10 else 1}f} times the time ({seconds})"


def enumeration(words: Sequence[str]) -> str:
    """Return words as a list in a sentence.

    Examples
    --------
    >>> enumeration(["cup", "sittable", "table"])
    'cup, sittable and table'
    """
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
