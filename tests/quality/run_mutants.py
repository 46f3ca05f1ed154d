"""`make mutants`: runs the tests that concern a module against each of its mutants (docs/mutants.md).

Each mutant has a process of its own, forked before the module is loaded, in which a finder gives its changed code to
whoever imports it. No file is changed.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import json
import os
import resource
import signal
import sys
from collections.abc import Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

import pytest
from tests.quality.equal import EQUAL
from tests.quality.mutation import Mutant, mutants_of, source_of
from tests.quality.suites import SUITES

#: A test run may take so many times the processor time that it takes without a change, and SPARE seconds.
FACTOR = 10
SPARE = 5
MEMORY = 4 << 30

#: What is loaded once, so that not every child loads it; nothing of ours.
PRELOADED = ("hypothesis", "networkx", "numpy", "piqp", "rich.console", "scipy.sparse.csgraph")

#: How pytest ends if a test fails, if one cannot be loaded, and by an error of its own, such as a lack of memory.
FAILED = (1, 2, 3)

KILLED, NEVER_ENDS, SURVIVED = "killed", "killed by never ending", "survived"


class _Loader(SourceFileLoader):
    def __init__(self, mutant: Mutant, path: str) -> None:
        super().__init__(mutant.module, path)
        self._code = mutant.code()

    def get_code(self, fullname: str) -> CodeType:
        return self._code


class _Finder:
    """Finds the mutant in place of its module."""

    def __init__(self, mutant: Mutant) -> None:
        self._mutant = mutant

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how to load the mutant; None for other modules."""
        if name != self._mutant.module:
            return None
        spec = PathFinder.find_spec(name, path)
        assert spec is not None
        assert spec.origin is not None
        spec.loader = _Loader(self._mutant, spec.origin)
        return spec


def _tests_in_child(mutant: Mutant | None, tests: Sequence[str], seconds: int, output: Path) -> None:
    """Run tests in this process, and end it: 0 if all pass. Never returns."""
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        with output.open("wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        if mutant is not None:
            sys.meta_path.insert(0, _Finder(mutant))
        os._exit(int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-m", "not deep", *tests])))
    finally:
        os._exit(70)


def _start(mutant: Mutant | None, tests: Sequence[str], seconds: int, output: Path) -> int:
    child = os.fork()
    if child == 0:
        _tests_in_child(mutant, tests, seconds, output)
    return child


def fate_of(status: int, taken: float, limit: int) -> str:
    """Return what a wait status says after so many seconds of the processor; SystemExit if nothing about the tests."""
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL):
        if taken < limit - 1:
            sys.exit("a test run was killed from outside; what was found before is kept")
        return NEVER_ENDS
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) not in (0, *FAILED):
        sys.exit(f"pytest could not run the tests: it ended with {os.WEXITSTATUS(status)}")
    return SURVIVED if status == 0 else KILLED


def _digest(source: str, tests: Sequence[str]) -> str:
    """Return a digest of a module's text and of tests: their arguments, and the files among these."""
    files = [Path(argument).read_text(encoding="utf-8") for argument in tests if argument.endswith(".py")]
    return hashlib.sha256("\0".join([source, *tests, *files]).encode()).hexdigest()[:16]


class Campaign:
    """The mutants of one module under its tests, some at a time; what is known already is read from a file.

    Attributes:
        fates: by name of the mutant.
    """

    def __init__(self, module: str, folder: Path) -> None:
        self.module, self.mutants, self.stages = module, mutants_of(module), SUITES[module]
        self._file = folder / f"{module}.jsonl"
        self._output = folder / "output"
        self._output.mkdir(parents=True, exist_ok=True)
        self._limits: list[int] = []
        source = source_of(module)
        self._digests = [_digest(source, stage) for stage in self.stages]
        self.fates = self._known()

    def _counts(self, fate: str) -> set[str]:
        """Return of what a result must be made to count: a killed mutant of its stage, a survivor of all of them."""
        return {_digest("", self._digests)} if fate == SURVIVED else set(self._digests)

    def _known(self) -> dict[str, str]:
        lines = self._file.read_text(encoding="utf-8").splitlines() if self._file.exists() else []
        found = [json.loads(line) for line in lines]
        return {
            one["mutant"]: one["fate"]
            for one in found
            if one["made of"] in self._counts(one["fate"]) and one["mutant"] in self.mutants
        }

    def _measure(self) -> None:
        """Run the stages without a mutant: what their limits of time are; SystemExit if they do not pass."""
        for number, tests in enumerate(self.stages):
            output = self._output / f"unchanged-{number}"
            child = _start(None, tests, 3600, output)
            _, status, used = os.wait4(child, 0)
            if status != 0:
                sys.exit(f"the tests of {self.module} fail without any mutant: see {output}")
            self._limits.append(SPARE + round(FACTOR * (used.ru_utime + used.ru_stime)))

    def run(self, processes: int) -> None:
        """Find the fates that are not known yet."""
        waiting = [(mutant, 0) for name, mutant in self.mutants.items() if name not in self.fates]
        if not waiting:
            return
        self._measure()
        waiting.reverse()
        running: dict[int, tuple[Mutant, int, Path]] = {}
        while waiting or running:
            while waiting and len(running) < processes:
                mutant, stage = waiting.pop()
                output = self._output / hashlib.sha256(f"{self.module} {mutant.name}".encode()).hexdigest()[:16]
                running[_start(mutant, self.stages[stage], self._limits[stage], output)] = mutant, stage, output
            child, status, used = os.wait4(-1, 0)
            mutant, stage, output = running.pop(child)
            fate = fate_of(status, used.ru_utime + used.ru_stime, self._limits[stage])
            if fate == SURVIVED and stage + 1 < len(self.stages):
                waiting.append((mutant, stage + 1))
                continue
            self._record(mutant, fate, self._digests[stage], output)

    def _record(self, mutant: Mutant, fate: str, made_of: str, output: Path) -> None:
        by = [line for line in output.read_text(errors="replace").splitlines() if line.startswith(("FAILED", "ERROR"))]
        if made_of not in [_digest(source_of(self.module), stage) for stage in self.stages]:
            sys.exit(f"{self.module} or its tests were changed while they ran: start again")
        made_of = made_of if fate != SURVIVED else _digest("", self._digests)
        line = {"mutant": mutant.name, "fate": fate, "made of": made_of, "by": by[:1]}
        with self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        self.fates[mutant.name] = fate
        output.unlink()
        print(f"{len(self.fates)}/{len(self.mutants)} {self.module}: {fate}: {mutant.name}", flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaigns, and return 1 if there is a survivor without a sentence, or a sentence without a survivor."""
    parser = argparse.ArgumentParser(prog="make mutants", description=__doc__)
    parser.add_argument("--processes", type=int, default=2, help="at a time (default: 2)")
    parser.add_argument("--results", type=Path, default=Path("out/mutants"), help="folder of what is known already")
    parser.add_argument("modules", nargs="*", default=list(SUITES), help="such as swarmproof.monitor.watch")
    options = parser.parse_args(arguments)
    for module in options.modules:
        if module not in SUITES:
            parser.error(f"{module} has no tests in tests/quality/suites.py; {next(iter(SUITES))} has")
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    for heavy in PRELOADED:
        importlib.import_module(heavy)
    wrong = False
    for module in options.modules:
        campaign = Campaign(module, options.results)
        campaign.run(options.processes)
        wrong |= says(campaign, EQUAL.get(module, {}))
    return int(wrong)


def says(campaign: Campaign, equal: Mapping[str, str]) -> bool:
    """Print what became of a module's mutants; return whether something is wrong."""
    survived = {name for name, fate in campaign.fates.items() if fate == SURVIVED}
    unexplained, gone = survived - equal.keys(), equal.keys() - campaign.mutants.keys()
    killed = equal.keys() - survived - gone
    endless = sum(fate == NEVER_ENDS for fate in campaign.fates.values())
    print(
        f"{campaign.module}: {len(campaign.mutants)} mutants, {len(campaign.mutants) - len(survived)} killed "
        f"({endless} by never ending), {len(survived) - len(unexplained)} equal, {len(unexplained)} survived"
    )
    for what, names in (
        ("survived, and no sentence says why", unexplained),
        ("has a sentence, but is no mutant any more", gone),
        ("has a sentence that says it is equal, but is killed", killed),
    ):
        for name in sorted(names):
            print(f"  {what}: {name}")
    return bool(unexplained or gone or killed)


if __name__ == "__main__":
    sys.exit(main())
