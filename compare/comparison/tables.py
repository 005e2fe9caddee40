"""The comparison as tables: on the terminal, and in Markdown with its answer and how it was made."""

from __future__ import annotations

from dataclasses import dataclass

from spherefunc_bullet.formats.units import format_duration, format_length

from ..evaluation.evaluation import FunctionQuality
from ..evaluation.impaired import share_rows
from ..evaluation.protocol import FAIR, PAPER
from .significance import Report, verdict_word


@dataclass(frozen=True, kw_only=True)
class TextTable:
    """A table of texts with a title and column names."""

    title: str
    columns: list[str]
    rows: list[list[str]]

    def markdown(self) -> str:
        """Return the table in Markdown, below its title."""
        lines = [self.columns, ["---"] + ["---:"] * (len(self.columns) - 1), *self.rows]
        return "\n".join([f"## {self.title}", "", *(f"| {' | '.join(line)} |" for line in lines)])


def tables(report: Report) -> list[TextTable]:
    """Return all tables of a comparison."""
    of_pairs = [label_table(report), histogram_table(report)] if report["agreement"] else []
    of_copies = [copies_table(report)] if "impaired" in report else []
    of_tasks = [task_table(report)] if "tasks" in report else []
    return [quality_table(report), *of_copies, *of_tasks, cost_table(report), radius_table(report), *of_pairs]


def quality_table(report: Report) -> TextTable:
    """Return the quality of each function by simulators and baselines, over trials and with each object left out."""
    rows = [
        [
            name.replace("_", " "),
            function,
            with_spread(row),
            *(number(row[key]) for key in ("precision", "recall", "accuracy", "f_measure_fair")),
            number(feature["leave_one_out"][function]["f_measure"]),
            "" if row["radius"] is None else format_length(row["radius"]),
        ]
        for function in report["functions"]
        for name, feature in (report["backends"] | report["baselines"]).items()
        for row in [feature["functions"][function]]
    ]
    known = [name for name in report["functions"] if name in PAPER]
    rows += [["the paper, its 200 models", name, f"{PAPER[name]:.2f}", *[""] * 6] for name in known]
    trials = report["experiment"]["trials"]
    title = f"{report['data']}, {report['objects']} objects, {report['train_size']} learnt, trials: {trials}"
    head = ["features", "function", "F", "precision", "recall", "accuracy", "F fair", "F leave-one-out", "radius"]
    return TextTable(title=f"{title}; {FAIR}", columns=head, rows=rows)


def copies_table(report: Report) -> TextTable:
    """Return the share of impaired copies that are still classified by their function, kind by kind."""
    copied = report["experiment"]["copied"]
    title = f"Does it still work? Copies of {copied} object{'s' * (copied != 1)} of each function, of others learnt"
    columns, rows = share_rows(report["impaired"])
    return TextTable(title=f"{title}: share still classified by the function", columns=columns, rows=rows)


def task_table(report: Report) -> TextTable:
    """Return the results of backends at the tasks other than labels."""
    rows, unable = [], []
    for task, of_task in report["tasks"].items():
        unable += [[task, name, "cannot do it", "", "", ""] for name in of_task["unable"]]
        for row in of_task["rows"]:
            figures = [number(row["value"]), str(row["asked"]), format_duration(row["seconds"])]
            rows.append([task, row["backend"], row["measure"], *figures])
    head = ["task", "backend", "measure", "value", "objects", "each takes"]
    return TextTable(title="What rigid bodies tell besides labels", columns=head, rows=rows + unable)


def keeping_table(report: Report) -> TextTable:
    """Return what vessels, vessels with a hole in the wall, and other objects keep when they are tilted."""
    rows, angles = [], []
    for name, score in report["tasks"].get("keeping", {}).get("backends", {}).items():
        angles = score["angles_deg"]
        curves = {"vessels": score["vessels"], "plates, trays, shelves, tables": score["others"]}
        curves |= {f"vessels, {one['kind'].replace('_', ' ')} % of the depth": one["kept"] for one in score["holed"]}
        rows += [[what, name, *(number(share) for share in curve)] for what, curve in curves.items()]
    head = ["mean share kept", "backend", *(f"at {angle:g}°" for angle in angles)]
    return TextTable(title="What is kept when it is tilted to all sides", columns=head, rows=rows)


def cost_table(report: Report) -> TextTable:
    """Return the cost of each simulator."""
    rows = []
    for name, row in report["backends"].items():
        seconds = (row["seconds_per_object"], row["seconds_per_object_p95"], row["seconds_total"])
        memory = "unknown" if row["peak_memory"] is None else f"{row['peak_memory'] / 2**20:,.0f} MiB"
        start = [name, ", ".join(map(format_length, row["radii"])), *map(format_duration, seconds)]
        rows.append([*start, rate(row["drops_per_second"]), memory, str(row["failed"])])
    head = ["backend", "radii", "median object", "95th percentile", "all objects", "drops/s", "peak memory", "failed"]
    return TextTable(title="Cost", columns=head, rows=rows)


def radius_table(report: Report) -> TextTable:
    """Return the quality and the cost of each radius alone."""
    functions, rows = list(report["functions"]), []
    for name, backend in report["backends"].items():
        for row in backend["by_radius"]:
            quality = [with_spread(row["functions"][function]) for function in functions]
            cost = [format_duration(row["seconds_per_object"]), rate(row["drops_per_second"])]
            rows.append([name, format_length(row["radius"]), *quality, *cost, number(row["settled_share"])])
    head = ["backend", "radius", *(f"F {name}" for name in functions), "median object", "drops/s", "settled"]
    return TextTable(title="One radius alone", columns=head, rows=rows)


def label_table(report: Report) -> TextTable:
    """Return on how many objects two simulators agree, and whose trials are better."""
    rows = []
    for pair in report["agreement"]:
        for function, row in pair["labels"].items():
            seeds = [number(pair["labels_of_two_seeds"][name][function]) for name in pair["backends"]]
            counts, difference = map(str, row["right_alone"].values()), pair["f_measures"][function]
            better = [f"{difference['difference']:+.3f}", number(difference["margin"]), verdict_word(difference)]
            start = [" / ".join(pair["backends"]), function, number(row["same"])]
            rows.append([*start, " / ".join(seeds), " / ".join(counts), *better])
    head = ["backends", "function", "same label", "two seeds", "right alone", "F second - first", "margin", "second is"]
    return TextTable(title="Agreement of labels, every object left out once", columns=head, rows=rows)


def histogram_table(report: Report) -> TextTable:
    """Return the distance between two simulators' histograms, and for comparison between two seeds of one."""
    rows = []
    for pair in report["agreement"]:
        for row, settled in zip(pair["histograms"], pair["settled"], strict=True):
            start = [" / ".join(pair["backends"]), format_length(row["radius"]), str(row["objects"])]
            within, shares = (" / ".join(map(number, each.values())) for each in (row["within"], settled["share"]))
            rows.append([*start, number(row["between"]), within, number(row["ratio"]), number(row["norm"]), shares])
    head = ["backends", "radius", "objects", "apart", "two seeds apart", "ratio", "norm", "settled"]
    title = f"Agreement of histograms, medians over the objects, of {report['objects_again']}, on which they differ; "
    title += "apart: their distance in spheres, norm: a histogram's own length"
    return TextTable(title=title, columns=head, rows=rows)


def markdown(report: Report) -> str:
    """Return the comparison in Markdown."""
    parts = ["# Comparison of simulators", report["answer"], *(table.markdown() for table in tables(report))]
    parts += ["## How it was made", report["timing"]]
    if report["left_out"]:
        parts.append(f"Left out of every backend, since one at least failed: {', '.join(report['left_out'])}.")
    parts.append("\n".join(f"- {name}: {value}" for name, value in report["machine"].items()))
    return "\n\n".join(parts) + "\n"


def number(value: float | None) -> str:
    """Return a number to three places; nothing if it is unknown."""
    return "" if value is None else f"{value:.3f}"


def with_spread(row: FunctionQuality) -> str:
    """Return an F-measure with its standard deviation over trials."""
    spread = "" if row["f_measure_std"] is None else f" ± {row['f_measure_std']:.3f}"
    return f"{row['f_measure']:.3f}{spread}"


def rate(value: float | None) -> str:
    """Return drops per second."""
    return "" if value is None else f"{value:,.0f}"
