"""Small changes to the code, one at a time, and which of them the tests notice.

By hand: ``python tests/support/mutating.py --sample 400`` (``make mutants``) prints what survived, and a table by file.
Cosmic Ray makes the changes, one at each of the places that are drawn; the same seed, the same ones. Each is tried in a
copy of the package by the tests that run its line, the quickest first, and those killed are not tried again (remove
``build/mutants`` to begin anew). Changes that nobody can see stand in ``equivalent_mutants.csv``, each with its reason.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import random
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from covering import BUILD, OWN, Copy

BINARY = "Add_Sub Sub_Add Mul_Div Div_Mul FloorDiv_Mul Pow_Mul Mod_Mul RShift_LShift LShift_RShift BitAnd_BitOr"
COMPARED = "Eq_NotEq NotEq_Eq Lt_LtE Lt_GtE LtE_Lt LtE_Gt Gt_GtE Gt_LtE GtE_Gt GtE_Lt Is_IsNot IsNot_Is"
OTHERS = "AddNot NumberReplacer ZeroIterationForLoop ReplaceTrueWithFalse ReplaceFalseWithTrue ReplaceAndWithOr"
OPERATORS = (
    *(f"ReplaceBinaryOperator_{pair}" for pair in BINARY.split()),
    *(f"ReplaceComparisonOperator_{pair}" for pair in COMPARED.split()),
    *(f"ReplaceUnaryOperator_Delete_{name}" for name in ("USub", "Not", "Invert")),
    *OTHERS.split(),
    *("ReplaceOrWithAnd", "ReplaceBreakWithContinue", "ReplaceContinueWithBreak"),
)
KNOWN, SAME = BUILD / "known.txt", Path(__file__).with_name("equivalent_mutants.csv")


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """One change of one line."""

    file: str  # below the package
    line: int
    before: str
    after: str
    source: str  # of the whole file, changed

    @property
    def key(self) -> str:
        return hash_of(self.file, self.source)


def places_of(path: Path) -> Iterator[list[tuple[str, int, int]]]:
    """Yield the changes that can be made at each place: operator, which occurrence, line.

    Decorators are left out, which decide how code is compiled or declared, what only type checkers read, and whether
    `zip` makes sure of what its callers promise.
    """
    source, places = path.read_text(), defaultdict(list)
    nodes, lines = list(ast_nodes(get_ast(source))), source.splitlines()
    for name in OPERATORS:
        operator = get_operator(f"core/{name}")()
        for occurrence, (start, _) in enumerate(span for node in nodes for span in operator.mutation_positions(node)):
            places[start].append((name, occurrence, start[0]))
    for (line, column), changes in places.items():
        text, before = lines[line - 1], lines[line - 1][:column].rstrip()
        no_product = text[column] == "*" and (before[-1:] or "(") in "([{,="  # but a list's or a call's star
        if not (text.lstrip().startswith("@") or "TYPE_CHECKING" in text or before.endswith("strict=") or no_product):
            yield changes


def sampled(copy: Copy, folders: Sequence[str], count: int, seed: int) -> list[Mutant]:
    """Return changes at so many places in some folders, each place as likely as any other."""
    roots = [copy.package / folder for folder in folders]
    files = [path for path in sorted(copy.package.rglob("*.py")) if any(path.is_relative_to(root) for root in roots)]
    places = [(path, place) for path in files for place in places_of(path)]
    chance = random.Random(seed)
    chosen = [(path, chance.choice(place)) for path, place in chance.sample(places, min(count, len(places)))]
    print(f"{len(chosen)} of {len(places)} places at which something can be changed, seed {seed}", flush=True)
    return [made(copy.package, path, *change) for path, change in chosen]


def made(package: Path, path: Path, name: str, occurrence: int, line: int) -> Mutant:
    """Return a change with what it makes of the file."""
    before = path.read_text()
    after = mutate_code(before, get_operator(f"core/{name}")(), occurrence)
    a, b = (" ".join(text.splitlines()[line - 1].split()) for text in (before, after))
    return Mutant(file=path.relative_to(package).as_posix(), line=line, before=a, after=b, source=after)


def verdict(copy: Copy, mutant: Mutant, known: set[str], same: set[tuple[str, ...]]) -> str:
    """Return what becomes of a change: same, killed or survived; what is not yet known is tried."""
    if (mutant.file, mutant.before, mutant.after) in same:
        return "same"
    killed, survived = f"{mutant.key} killed", f"{mutant.key} survived {hash_of(*copy.tests)}"
    if killed not in known and survived not in known:
        known.add(killed if copy.fails_with(mutant.file, mutant.line, mutant.source) else survived)
        KNOWN.write_text("\n".join(sorted(known)))
    return "killed" if killed in known else "survived"


def lines_gone(copy: Copy, same: set[tuple[str, ...]]) -> list[str]:
    """Return the lines whose changes nobody can see that are in their files no more."""
    texts = {file: (copy.package / file).read_text() if (copy.package / file).exists() else "" for file, *_ in same}
    lines = {file: {" ".join(line.split()) for line in text.splitlines()} for file, text in texts.items()}
    return [f"{file}: {before}" for file, before, _ in sorted(same) if before not in lines[file]]


def hash_of(*texts: str) -> str:
    """Return the hash of some texts."""
    return hashlib.sha256(" ".join(texts).encode()).hexdigest()[:32]


def interval(hits: int, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share."""
    share, z = hits / count, 1.96
    middle, half = share + z * z / 2 / count, z * (share * (1 - share) / count + z * z / 4 / count**2) ** 0.5
    return (middle - half) / (1 + z * z / count), (middle + half) / (1 + z * z / count)


def print_table(found: dict[str, Counter]):
    """Print what became of the changes to each file, and of all."""
    total = sum(found.values(), Counter())
    print(f"{'file':<42}{'changes':>8}{'same':>6}{'killed':>8}{'survived':>10}{'share':>7}")
    for file, row in [*sorted(found.items()), ("all", total)]:
        count = row["killed"] + row["survived"]
        share = f"{row['killed'] / count:.2f}" if count else "-"
        print(f"{file:<42}{row.total():>8}{row['same']:>6}{row['killed']:>8}{row['survived']:>10}{share:>7}")
    low, high = interval(total["killed"], total["killed"] + total["survived"])
    print(f"of all such changes {low:.2f} to {high:.2f} are killed, with 95 % confidence")


def main():
    """Try a sample of changes, print those that survive as they are found, and a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("folders", nargs="*", default=[*OWN])
    given = parser.parse_args()
    copy = Copy(given.folders)
    same = {tuple(row[:3]) for row in [*csv.reader(SAME.open())][1:]}
    print("".join(f"no such line, though {SAME.name} has it: {line}\n" for line in lines_gone(copy, same)), end="")
    known = set(KNOWN.read_text().splitlines()) if KNOWN.exists() else set()
    found = defaultdict(Counter)
    with suppress(KeyboardInterrupt):  # what was tried by then is a sample too
        for mutant in sampled(copy, given.folders, given.sample, given.seed):
            said = verdict(copy, mutant, known, same)
            found[mutant.file][said] += 1
            if said == "survived":
                print(f"{mutant.file}:{mutant.line}\n    - {mutant.before}\n    + {mutant.after}", flush=True)
    print_table(found)


if __name__ == "__main__":
    main()
