"""Which tests run which line of the package, so that a change is tried by few (see `mutating`)."""

from __future__ import annotations

import ast
import compileall
import hashlib
import json
import math
import os
import shutil
import signal
import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path

import numba
import numpy  # noqa: F401  what is loaded here, forks need not load
import pytest
import scipy.spatial  # noqa: F401
import sklearn.ensemble  # noqa: F401
import sklearn.model_selection  # noqa: F401
import sklearn.utils.estimator_checks  # noqa: F401
import trimesh  # noqa: F401
from checkout import ROOT, TESTS

BUILD = ROOT / "build" / "mutants"
KERNELS = BUILD / "kernels"
OWN = {  # the tests of each folder, or file
    "fast_sim": "roller nearby strips kept_with_clouds conformance",
    "bullet": "flights bullet_arithmetic bullet_bodies bullet_collision bullet_columns bullet_loading bullet_world"
    " bullet_physics bullet_shapes pieces poses standing conformance conformance_mechanics carrying round_bottoms",
    "settling": "enclosure settling drops simulation_cache early_answers",
    "learning": "copies doubts labels turned settling resting_profile classifier histogram model_file"
    " early_answers one_view view drops learning_arithmetic learnt_models"
    " limits unseen_kinds poses estimators falling_over decision columns",
    "clouds/links.py": "leaks flooding",
    "clouds/water.py": "leaks flooding places falling_over learnt_models",
    "classification.py": "leaks one_view falling_over classifier doubts learnt_models answers early_answers decision",
}
SECONDS = 30.0  # of the processor, of tests that one change is tried by, at most


class Copy:
    """A copy of the package as it is installed, to be changed, and what its tests run and take."""

    def __init__(self, folders: Sequence[str]):
        self.tree, self.package = BUILD / "tree", BUILD / "tree" / "spherefunc_bullet"
        shutil.rmtree(self.tree, ignore_errors=True)
        for folder in ("spherefunc_bullet", "fast_sim", "scenes", "compare"):
            target = self.package / folder.replace("spherefunc_bullet", "")
            shutil.copytree(ROOT / folder, target, ignore=shutil.ignore_patterns("__pycache__"))
        compileall.compile_dir(self.package, quiet=2)
        of_package = b"".join(path.read_bytes() for path in sorted(self.package.rglob("*.py")))
        self.seconds: dict[str, float] = {}
        self.reach: Counter[str] = Counter()  # how many lines each test runs
        self.tests: list[str] = []  # names of their files and contents
        self.covered: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
        for name in dict.fromkeys(name for folder in folders for name in OWN[folder].split()):
            path = next(TESTS.rglob(f"test_{name}.py"))
            known = BUILD / f"test_{name}-{hashlib.sha256(of_package + path.read_bytes()).hexdigest()[:16]}.json"
            self.tests.append(known.stem)
            if not known.exists():
                self.run([str(path)], math.inf, known)
            self.record_outcome(json.loads(known.read_text()))

    def record_outcome(self, found: tuple[dict[str, float], dict[str, dict[str, list[str]]]]):
        """Take note of what the tests of one file take and run."""
        self.seconds |= found[0]
        for file, lines in found[1].items():
            for line, tests in lines.items():
                self.covered[file][line] += tests
                self.reach.update(tests)

    def tests_of(self, file: str, line: int) -> list[str]:
        """Return the tests to try a line by: those that run it; of what is compiled or a constant, its file's too.

        Those that run the fewest lines come first, which are of that line more than of others.
        """
        lines = self.covered.get(file, {})
        nearest = max((int(other) for other in lines if int(other) <= line), default=0)
        ranked = [lines.get(str(nearest), [])]
        if not ranked[0] or self.is_run_once(file, line) or self.is_compiled(file):
            own = {f"test_{name}.py" for folder in OWN if file.startswith(folder) for name in OWN[folder].split()}
            ranked += [[test for tests in lines.values() for test in tests]]  # they run what calls its kernels, too
            ranked += [[test for test in self.seconds if test.split("::")[0].rpartition("/")[2] in own]]
        ordered = dict.fromkeys(test for some in ranked for test in sorted(some, key=lambda name: self.reach[name]))
        chosen, spent = [], 0.0
        for test in ordered:
            spent += self.seconds[test]
            if spent < SECONDS or not chosen:
                chosen.append(test)
        return chosen

    def is_run_once(self, file: str, line: int) -> bool:
        """Return whether a line is run by who imports its file first: no function's body, but a constant or default."""
        nodes = ast.walk(ast.parse((self.package / file).read_text()))
        bodies = [(node.body[0].lineno, node.end_lineno) for node in nodes if isinstance(node, ast.FunctionDef)]
        return not any(first <= line <= last for first, last in bodies)

    def is_compiled(self, file: str) -> bool:
        """Return whether a file holds kernels."""
        return any(word in (self.package / file).read_text() for word in ("njit", "_jit", "intrinsic"))

    def fails_with(self, file: str, line: int, source: str) -> bool:
        """Return whether tests fail, hang or crash when a file has another source, which differs in a line."""
        path, tests = self.package / file, self.tests_of(file, line)
        kept, times = path.read_bytes(), path.stat()
        if self.is_compiled(file):  # of this folder nothing that is compiled holds any more
            forgotten = {f"{folder.name}_" for folder in (path.parent, self.package / file.split("/")[0])}
        else:
            forgotten = set()
        try:
            path.write_text(source)
            limit = 60 + 4 * sum(self.seconds[test] for test in tests)
            return self.run([str(TESTS / test) for test in tests], limit, forgotten=forgotten) != 0
        finally:
            path.write_bytes(kept)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def run(self, tests: Sequence[str], limit: float, covered: Path | None = None, forgotten: set[str] = frozenset()):
        """Run tests in a fork of this process; return pytest's exit code, or the negative signal that ended it."""
        scratch = BUILD / "scratch"
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir(parents=True)
        kernels = KERNELS
        if forgotten:
            kernels = shutil.copytree(KERNELS, scratch / "kernels")
            for old in [old for start in forgotten for old in kernels.glob(f"{start}*")]:
                shutil.rmtree(old)
        child = get_context("fork").Process(target=run_tests, args=(self.tree, tests, kernels, covered))
        child.start()
        try:
            child.join(None if limit == math.inf else limit)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # with what its tests have left running
            child.join()
        return child.exitcode


def run_tests(tree: Path, tests: Sequence[str], kernels: Path, covered: Path | None):
    """Run tests of the package in a tree until one fails, or all of them to write down what they cover."""
    os.setsid()
    scratch = BUILD / "scratch"
    with open(scratch / "log.txt", "w") as log:
        os.dup2(log.fileno(), 1), os.dup2(log.fileno(), 2)
    os.environ |= {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(kernels), "PYTHONDONTWRITEBYTECODE": "1"}
    os.environ |= {"SPHEREFUNC_CACHE": str(scratch / "cache"), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    numba.config.CACHE_DIR, sys.dont_write_bytecode = str(kernels), covered is None
    sys.path.insert(0, str(tree))
    how = [
        "-q",
        "-p",
        "no:cacheprovider",
        "-p",
        "spherefunc_bullet.conformance.option",
        "--basetemp",
        f"{scratch}/temp",
    ]
    if covered is None:
        os._exit(pytest.main(["-x", *how, *tests]))
    recorder = Recorder(tree / "spherefunc_bullet")
    pytest.main([*how, *tests], plugins=[recorder])
    covered.write_text(json.dumps(recorder.result()))
    os._exit(0)


class Recorder:
    """Notes how long each test takes that passes, and which lines it runs."""

    def __init__(self, package: Path):
        import coverage

        self.package, self.seconds = package, {}
        wanted = [f"{package}/{folder}" if folder.endswith(".py") else f"{package}/{folder}/*" for folder in OWN]
        self.coverage = coverage.Coverage(
            data_file=str(BUILD / "coverage"), include=wanted, config_file=False, messages=False
        )
        self.coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item):
        self.coverage.switch_context(item.nodeid)
        result = yield
        self.coverage.switch_context("")
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef, request: pytest.FixtureRequest):
        """Take what is made once for several tests as run by all tests of the file, and not by the first alone."""
        test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" (")[0]
        self.coverage.switch_context(test if fixturedef.scope == "function" else test.split("::")[0])
        result = yield
        self.coverage.switch_context(test)
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item):
        """Take the time of the processor, which is the same on a machine that has more to do."""
        started = sum(os.times()[:4])
        result = yield
        self.seconds[item.nodeid.removeprefix("tests/")] = sum(os.times()[:4]) - started
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport):
        if report.when == "call" and not report.passed:
            self.seconds.pop(report.nodeid.removeprefix("tests/"), None)

    def result(self) -> tuple[dict[str, float], dict[str, dict[int, list[str]]]]:
        """Return each test's seconds, and of each file of the package the tests that run its lines."""
        self.coverage.stop()
        data, found = self.coverage.get_data(), {}
        for file in data.measured_files():
            lines = data.contexts_by_lineno(file).items()
            by = {line: {each.removeprefix("tests/") for each in tests} for line, tests in lines}
            kept = {line: [test for test in self.seconds if {test, test.split("::")[0]} & by[line]] for line in by}
            found[str(Path(file).relative_to(self.package))] = kept
        return self.seconds, found
