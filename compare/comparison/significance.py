"""Which simulator tells functions better, and at what price: differences between paired trials, and one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

BETTER, WORSE, LEVEL, UNKNOWN = "better", "worse", "level", "unknown"
CONFIDENCE = 0.95


def paired_differences(first: dict[str, dict], second: dict[str, dict], train: int, test: int) -> dict[str, dict]:
    """Return, per function, how much better the second tells it than the first, over the same trials."""
    return {
        name: paired_difference(first[name]["f_measures"], second[name]["f_measures"], train, test) for name in first
    }


def paired_difference(first: Sequence[float], second: Sequence[float], train: int, test: int) -> dict:
    """Return the mean of second minus first, its margin, and whether the second is better, worse or level.

    The trials share objects, so they are not independent, and the more of them there were the surer an ordinary
    t-test would be of nothing. The margin is the half width of the 95 % interval of Nadeau and Bengio's corrected
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
    # F-measures are kept to four places: what differs by less does not differ.
    verdict = LEVEL if abs(mean) <= max(margin, 5e-5) else BETTER if mean > 0 else WORSE
    return {"difference": round(mean, 4), "margin": round(margin, 4), "verdict": verdict}


def answer(report: dict) -> str:
    """Return in one sentence which simulator is how much better or worse at telling functions, at what price.

    Parameters
    ----------
    report : dict
        As `spherefunc compare` writes it, of which ``backends`` (their ``functions`` with ``f_measures``,
        ``seconds_per_object`` and ``radii``), ``train_size`` and ``test_size`` are looked at. All are compared with
        the one that takes the fewest seconds.
    """
    backends = report["backends"]
    cheap, *others = sorted(backends, key=lambda name: backends[name]["seconds_per_object"])
    if not others:
        return f"{cheap} was compared with no other backend: {alone(backends[cheap])}."
    sizes = report["train_size"], report["test_size"]
    said_of = [clause(name, backends[name], cheap, backends[cheap], sizes) for name in others]
    return f"Beside {cheap}, {'; '.join(said_of)}."


def alone(backend: dict) -> str:
    """Return one backend's F-measures and price."""
    told = listed([f"{name} {row['f_measure']:.2f}" for name, row in backend["functions"].items()])
    return f"F-measures of {told} at {spoken(backend['seconds_per_object'])} an object"


def clause(name: str, backend: dict, cheap: str, cheaper: dict, sizes: tuple[int, int]) -> str:
    """Return what one backend gives and costs beside the cheapest."""
    differences = paired_differences(cheaper["functions"], backend["functions"], *sizes)
    return f"{quality_said(name, differences)}, {price(backend, cheaper)}"


def quality_said(name: str, differences: dict[str, dict]) -> str:
    """Return in words at which functions a backend is better, worse and level."""
    by = {each: [f for f, row in differences.items() if row["verdict"] == each] for each in (BETTER, WORSE, LEVEL)}
    if not any(by.values()):
        told = listed([f"{function} by {signed(row)}" for function, row in differences.items()])
        return f"{name} differs at {told} in one trial, too few to tell"
    parts = [f"{each} at {listed([said(f, differences[f]) for f in by[each]])}" for each in (BETTER, WORSE) if by[each]]
    if by[LEVEL]:
        largest = max(abs(differences[function]["difference"]) for function in by[LEVEL])
        within = f"F-measures differ by {largest:.3f} at most, within the spread of the trials"
        parts.append(f"level at {listed(by[LEVEL])} ({within})")
    return f"{name} is {listed(parts)}"


def said(function: str, row: dict) -> str:
    """Return a function with its difference and margin."""
    return f"{function} (F {signed(row)} ± {row['margin']:.3f})"


def signed(row: dict) -> str:
    """Return a difference with its sign."""
    return f"{row['difference']:+.3f}"


def price(backend: dict, cheaper: dict) -> str:
    """Return how many times the seconds a backend takes."""
    dear, cheap = backend["seconds_per_object"], cheaper["seconds_per_object"]
    own = "" if backend["radii"] == cheaper["radii"] else ", each with radii of its own"
    beside = f"{spoken(dear)} against {spoken(cheap)} an object{own}"
    if not cheap > 0:
        return f"at {beside}"
    times = dear / cheap
    return f"at {f'{times:.0f}' if times >= 10 else f'{times:.1f}'} times the time ({beside})"


def spoken(seconds: float) -> str:
    """Return seconds as people read them.

    Examples
    --------
    >>> spoken(0.0123), spoken(2.5), spoken(131.4)
    ('12 ms', '2.5 s', '131 s')
    """
    if seconds < 1:
        return f"{1000 * seconds:.{0 if seconds >= 0.01 else 1}f} ms"
    return f"{seconds:.1f} s" if seconds < 100 else f"{seconds:.0f} s"


def listed(words: Sequence[str]) -> str:
    """Return words as a list in a sentence.

    Examples
    --------
    >>> listed(["cup", "sittable", "table"])
    'cup, sittable and table'
    """
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
