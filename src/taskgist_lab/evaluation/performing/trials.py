"""Trials: robots perform the six tasks in rooms that nobody developed on; how often, how cleanly, how long.

A trial is a room, a task and a robot. The clause is that of the shipped study, by the rule that is asked for. Whether
the task can be performed there is for ``solvable`` to say, before the robot is asked; then
``pipeline.performing.perform`` is asked once, with the processor's time measured, and what it returns is looked at
again: by the second auditor, which shares no code with the first, by the facts of the recording, and by the task's own
geometric check, by lines of sight and distances alone (``generator.intentions``). For a clause that is too weak is
performed with ease, and what was done is the task no more::

    found = performed_trials(count=10, seed=2000, tasks=TASKS, robots=ROBOTS)
    for sheet in sheets(found): ...

``TASK_OF`` has three more "tasks": a thing is covered, the view to it cleared, or another robot helps; no other means
is allowed then, and the rooms are made for it (``means_rooms``), which no sampling proves to be solvable.

Tasks that take a thing away begin with it before the target agent. An arrangement of things with which the paper's
clause cannot come true from the start (nothing is easier to reach than what is at hand) is drawn anew, a few times;
so rooms are the same by whichever rule their tasks are learned.
"""

from __future__ import annotations

import json
import math
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from taskgist.common.files import reading, writing
from taskgist.common.workers import Progress, in_order, silent
from taskgist.errors import InputError, SceneError, TaskgistError
from taskgist.facts.values import Unknown
from taskgist.learning import Knowledge
from taskgist.learning.task_clauses import BY_RULE, learned_clause
from taskgist.learning.understanding import PAPER, Clause, conjunction
from taskgist.pipeline.explain import explain_all
from taskgist.pipeline.performing import Outcome, perform
from taskgist.pipeline.shipped import TASKS, shipped_study
from taskgist.planning.requests import Request
from taskgist.recording.recording import Recording
from taskgist.world.scene import Scene
from taskgist_lab.evaluation.performing.means_rooms import TASK_OF
from taskgist_lab.evaluation.performing.means_rooms import room_for as room_for_means
from taskgist_lab.evaluation.performing.rooms import ROBOT, TARGET, THING, RoomToPerformIn, room_to_perform_in
from taskgist_lab.evaluation.performing.second_audit import second_audit
from taskgist_lab.evaluation.performing.solvable import Solvable, goal_of, solvable
from taskgist_lab.evaluation.sheets import NONE, Sheet
from taskgist_lab.evaluation.values import Result, rounded
from taskgist_lab.generator.intentions import CHECKS
from taskgist_lab.paper.displacements import wilson

ROBOTS = ("pr2", "jido")
"""Profiles of the robots that perform."""
TAKE_AWAY = frozenset({"hide", "put away", "hide away"})
"""Tasks that begin with the thing before the target agent."""
ARRANGEMENTS = 10
"""How often things are arranged anew where the task cannot be from the start."""

# --- What came of a trial.

FOUND = "found"
"""The gate of what was found: none."""
GATES: Mapping[str, str] = {
    "start": "from the start it cannot be",
    "places": "no place satisfies the goal",
    "taker": "the target's hand gets to none of the places",
    "performer": "the robot does not bring it there",
    "audit": "carried out, but the first audit or the facts refuse it",
    "error": "an error",
}
"""Where a request is refused, in the order in which the planner gets there."""


@dataclass(frozen=True)
class Trial:
    """A room, a task, a robot, and what came of it.

    Attributes:
        number: Number of the room among those of its seed.
        room: Its name; seed, number and attempt are in it.
        task: The task.
        robot: Profile of the robot.
        solvable: Whether the dense sampling finds it possible.
        sampled: Where, or why not.
        gate: Where it was refused; ``FOUND`` if a plan was returned.
        why: The most frequent reasons there, in words.
        spoiled: Why plans were thrown away after they were carried out.
        faults: What the second auditor says of the returned plan.
        controllable: Whether all that was wanted holds by the facts of the recording; None without a plan.
        strict: Whether the whole clause holds; None without a plan, or if that is unknown.
        is_task: Whether what was performed passes the task's own geometric check; None without a plan.
        as_shown: Whether all circumstances of the clause hold; None without a plan, if that is unknown, or if
            there are none.
        means: How the thing got there.
        carrier: What carries it in the end.
        cpu_s: The processor's time that it took.
    """

    number: int
    room: str
    task: str
    robot: str
    solvable: bool
    sampled: str
    gate: str
    why: tuple[str, ...] = ()
    spoiled: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    controllable: bool | None = None
    strict: bool | None = None
    is_task: bool | None = None
    as_shown: bool | None = None
    means: str = ""
    carrier: str = ""
    cpu_s: float = 0.0

    @property
    def found(self) -> bool:
        """Whether a plan was returned."""
        return self.gate == FOUND

    @property
    def clean(self) -> bool:
        """Whether a plan was returned in which the second auditor finds nothing."""
        return self.found and not self.faults


@cache
def _study() -> Knowledge:
    paths = [path for paths in shipped_study().values() for path in paths]
    return Knowledge().add(*explain_all(paths, processes=1))


def clauses(rule: str = PAPER) -> dict[str, Clause]:
    """What the shipped study teaches by a rule, by task; and by means.

    Raises:
        UnknownNameError: There is no such rule.
    """
    found = {task: learned_clause(_study(), task, rule) for task in TASKS}
    return found | {means: found[task] for means, task in TASK_OF.items()}


def room_for(task: str, clause: Clause, robot: str, *, seed: int, number: int) -> tuple[RoomToPerformIn, Scene]:
    """A room, its things arranged so that the task can be from the start, if one of some arrangements is so."""
    for attempt in range(ARRANGEMENTS):
        room = room_to_perform_in(seed, number, attempt, near=task in TAKE_AWAY)
        scene = room.scene(robot)
        if not goal_of(scene, clause, TARGET, THING).impossible:
            break
    return room, scene


def trial(task: str, clause: Clause, robot: str, *, seed: int, number: int, arranged_by: Clause | None = None) -> Trial:
    """Have a robot perform a task in a room, and look at what comes of it.

    Args:
        task: The task, or a means.
        clause: What it means.
        robot: Profile of the robot.
        seed: Seed of the rooms.
        number: Number of the room.
        arranged_by: The clause that must be possible from the start; None: the same.
    """
    for means in TASK_OF:
        if task == means:
            scene = room_for_means(means, robot, seed, number)
            possible = Solvable(True, "the room is made for it")
            allow = ("shelf",) if means == "relay" else None  # the other side of the counter
            request = Request(clause, ROBOT, TARGET, THING, means=(means, "slide"), allow=allow)
            return tried(number, scene.name, scene, task, clause, robot, possible, request)
    room, scene = room_for(task, arranged_by or clause, robot, seed=seed, number=number)
    possible = solvable(scene, clause, ROBOT, TARGET, THING)
    return tried(number, room.name, scene, task, clause, robot, possible)


def tried(
    number: int,
    name: str,
    scene: Scene,
    task: str,
    clause: Clause,
    robot: str,
    possible: Solvable,
    request: Request | None = None,
) -> Trial:
    """Have a robot perform a task in a scene.

    Args:
        number: Number of the room.
        name: Its name.
        scene: The room, with the robot.
        task: The task.
        clause: What it means.
        robot: Profile of the robot.
        possible: What the dense sampling says.
        request: What is asked for; None: the task, by any means.
    """
    about = partial(Trial, number, name, task, robot, possible.possible, possible.why)
    start_s = time.process_time()
    try:
        outcome = perform(scene, request or Request(clause, ROBOT, TARGET, THING))
    except TaskgistError as error:
        return about(gate="error", why=(str(error),), cpu_s=rounded(time.process_time() - start_s))
    cpu_s = rounded(time.process_time() - start_s)
    if not outcome.performances:
        gate, why = refusal(outcome)
        return about(gate=gate, why=why, spoiled=outcome.spoiled, cpu_s=cpu_s)
    found = outcome.performances[0]
    recording = found.execution.recording
    acted = dict.fromkeys([(action.performer, action.thing) for action in found.plan.actions])
    faults = [
        fault
        for performer, thing in acted
        for fault in second_audit(scene, performer, thing, recording.times_s, recording.qpos, found.execution.holds)
    ]
    as_shown = conjunction(iter(found.circumstances.values()))
    return about(
        gate=FOUND,
        spoiled=outcome.spoiled,
        faults=tuple(fault.text for fault in faults),
        controllable=all(each.holds(found.explanation.nodes) is True for each in outcome.goal.controllable),
        strict=None if isinstance(found.strict, Unknown) else found.strict,
        is_task=is_task(task, recording),
        as_shown=None if isinstance(as_shown, Unknown) or not found.circumstances else as_shown,
        means=found.plan.candidate.means,
        carrier=found.plan.candidate.carrier,
        cpu_s=cpu_s,
    )


def is_task(task: str, recording: Recording) -> bool | None:
    """Whether a recording passes the geometric check of a task, or of that of a means; None if it has none."""
    name = next((of for means, of in TASK_OF.items() if means == task), task)
    if name not in CHECKS:
        return None
    try:
        CHECKS[name](recording)
    except SceneError:
        return False
    return True


def refusal(outcome: Outcome) -> tuple[str, tuple[str, ...]]:
    """The farthest gate that a request got to, and the three most frequent reasons there."""
    search = outcome.search
    if outcome.goal.impossible:
        return "start", tuple(each.why for each in outcome.goal.impossible)
    if outcome.spoiled:
        return "audit", outcome.spoiled[:3]
    if search.others and not search.places:
        return "performer", tuple(f"{each.what}: {each.why}" for each in search.others[:3])
    if search.tried or search.refusals:
        return "performer", tuple(f"{count} × {text}" for text, count in search.refusals.most_common(3))
    if search.out_of_hand and not search.missed:
        return "taker", (f"{search.out_of_hand} of {search.places} places",)
    return "places", tuple(f"{count} of {search.places} fail {each}" for each, count in search.missed.most_common(3))


# --- Many of them.


@dataclass(frozen=True)
class TrialsFound(Result):
    """Trials.

    Attributes:
        seed: Seed of the rooms.
        trials: All of them.
        rule: By which rule their clauses were learned.
    """

    seed: int
    trials: tuple[Trial, ...]
    rule: str = PAPER

    def of(self, task: str | None = None, robot: str | None = None) -> list[Trial]:
        """Those of a task and of a robot; None: of all."""
        return [each for each in self.trials if task in (None, each.task) and robot in (None, each.robot)]

    @property
    def tasks(self) -> tuple[str, ...]:
        """Tasks, in the order in which they came."""
        return tuple(dict.fromkeys(each.task for each in self.trials))

    @property
    def robots(self) -> tuple[str, ...]:
        """Robots, likewise."""
        return tuple(dict.fromkeys(each.robot for each in self.trials))

    @classmethod
    def of_json(cls, document: Mapping[str, Any]) -> TrialsFound:
        """From plain data, as ``to_json`` gives them."""
        lists = ("why", "spoiled", "faults")
        trials = (Trial(**{**each, **{name: tuple(each[name]) for name in lists}}) for each in document["trials"])
        return cls(document["seed"], tuple(trials), document.get("rule", PAPER))

    def to_json(self) -> dict[str, Any]:
        """Plain data: shares by task and robot, and every trial."""
        rows = [
            {"task": task, "robot": robot, **Tally.of(self.of(task, robot)).to_json()}
            for task in self.tasks
            for robot in self.robots
        ]
        return {"seed": self.seed, "rule": self.rule, "rows": rows, "trials": [asdict(each) for each in self.trials]}


@dataclass(frozen=True)
class Share:
    """So many of so many, with the interval in which the true share lies with 95 % confidence [Wilson 1927]."""

    count: int
    of: int

    @property
    def interval(self) -> tuple[float, float]:
        """Both ends of the interval; from 0 to 1 if there are none."""
        return wilson(self.count, self.of) if self.of else (0.0, 1.0)

    @property
    def text(self) -> str:
        """For people."""
        if not self.of:
            return NONE
        low, high = self.interval
        return f"{self.count} of {self.of}, {self.count / self.of:.0%} ({low:.0%}-{high:.0%})"

    def to_json(self) -> dict[str, float]:
        """Plain data."""
        low, high = self.interval
        return {"count": self.count, "of": self.of, "low": rounded(low), "high": rounded(high)}


def _share(truths: Iterable[bool | None]) -> Share:
    """Those that are true, of those that are known."""
    known = [truth for truth in truths if truth is not None]
    return Share(sum(known), len(known))


@dataclass(frozen=True)
class Tally:
    """What some trials come to.

    Attributes:
        solvable: Of all, those that can be solved.
        found: Of these, those in which a plan was returned.
        clean: Of all returned plans, those in which the second auditor finds nothing.
        controllable: Of these, those in which all that is wanted holds.
        strict: Of these, those in which the whole clause holds.
        is_task: Of those that were checked, those that pass the task's own geometric check.
        as_shown: Of those of which it is known, those in which all circumstances hold.
        unsolvable_found: Plans where the sampling found none: it is no proof.
        cpu_s: Median, and 95 % quantile, of the time where a plan was found; NaN without.
        refusal_s: Median, and most, of the time that a refusal took.
    """

    solvable: Share
    found: Share
    clean: Share
    controllable: Share
    strict: Share
    is_task: Share
    as_shown: Share
    unsolvable_found: int
    cpu_s: tuple[float, float]
    refusal_s: tuple[float, float]

    @classmethod
    def of(cls, trials: Iterable[Trial]) -> Tally:
        """Of trials."""
        trials = list(trials)
        possible = [each for each in trials if each.solvable]
        found = [each for each in trials if each.found]
        times = [each.cpu_s for each in found] or [math.nan]
        refused = [each.cpu_s for each in trials if not each.found] or [math.nan]
        return cls(
            Share(len(possible), len(trials)),
            Share(sum(each.found for each in possible), len(possible)),
            Share(sum(each.clean for each in found), len(found)),
            Share(sum(each.controllable is True for each in found), len(found)),
            Share(sum(each.strict is True for each in found), len(found)),
            _share([each.is_task for each in found]),
            _share([each.as_shown for each in found]),
            sum(not each.solvable for each in found),
            (rounded(np.median(times)), rounded(np.quantile(times, 0.95))),
            (rounded(np.median(refused)), rounded(max(refused))),
        )

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        names = ("solvable", "found", "clean", "controllable", "strict", "is_task", "as_shown")
        shares = {name: getattr(self, name).to_json() for name in names}
        times = {"cpu_s": self.cpu_s, "refusal_s": self.refusal_s}
        told = {name: [None if math.isnan(each) else each for each in pair] for name, pair in times.items()}
        return {**shares, "unsolvable_found": self.unsolvable_found, **told}


def performed_trials(
    *,
    count: int,
    seed: int,
    tasks: Sequence[str] = TASKS,
    robots: Sequence[str] = ROBOTS,
    rule: str = PAPER,
    processes: int | None = None,
    kept: Path | None = None,
    progress: Progress = silent,
) -> TrialsFound:
    """Trials in some rooms, room after room.

    Args:
        count: How many rooms.
        seed: Their seed.
        tasks: Which tasks.
        robots: Profiles of the robots.
        rule: By which rule the tasks are learned.
        processes: Processes; None: one for each core.
        kept: A file that need not exist: its trials are not made anew, and each new one is written to it as it comes.
        progress: Told how far it is.

    Raises:
        InputError: The number of processes is less than one; the file holds something else, or trials of another seed
            or rule.
        UnknownNameError: There is no such rule.
    """
    jobs = [(number, task, robot) for number in range(count) for task in tasks for robot in robots]
    known = {(each.number, each.task, each.robot): each for each in (_kept(kept, seed, rule).trials if kept else ())}
    missing = [job for job in jobs if job not in known]
    progress("learns the tasks from the study", 0.0)
    for each in each_trial(missing, seed, processes, rule):
        known[each.number, each.task, each.robot] = each
        done = sum(job in known for job in jobs)
        progress(f"{each.task}, {each.robot}: {done} of {len(jobs)}", done / len(jobs))
        if kept:
            _keep(TrialsFound(seed, tuple(known.values()), rule), kept)
    return TrialsFound(seed, tuple(known[job] for job in jobs), rule)


def _kept(path: Path, seed: int, rule: str) -> TrialsFound:
    """The trials of a file; none if there is no such file."""
    if not path.exists():
        return TrialsFound(seed, (), rule)
    try:
        with reading(path, is_input=False) as stream:
            found = TrialsFound.of_json(json.load(stream)["perform"])
    except (ValueError, KeyError, TypeError) as problem:
        hint = "give a file that an earlier run with --kept wrote, or a new name"
        raise InputError("holds no trials", where=str(path), field="kept", hint=hint) from problem
    if found.seed != seed:
        hint = f"give --seed {found.seed}, or another file"
        raise InputError("holds trials of another seed", where=str(path), field="seed", value=seed, hint=hint)
    if found.rule != rule:
        hint = f"give --rule {found.rule}, or another file"
        raise InputError("holds trials by another rule", where=str(path), field="rule", value=rule, hint=hint)
    return found


def _keep(found: TrialsFound, path: Path) -> None:
    with writing(path, replace=True) as stream:
        stream.write(json.dumps({"perform": found.to_json()}).encode())


def each_trial(
    jobs: Sequence[tuple[int, str, str]], seed: int, processes: int | None = None, rule: str = PAPER
) -> Iterator[Trial]:
    """Trials as they come, for each number of a room, task and robot."""
    if not jobs:
        return iter(())
    meanings, arranging = clauses(rule), clauses(PAPER)
    _warm_up(meanings, jobs, seed)
    return in_order(partial(_trial_of, meanings, arranging, jobs, seed), len(jobs), processes)


def _trial_of(
    meanings: Mapping[str, Clause],
    arranging: Mapping[str, Clause],
    jobs: Sequence[tuple[int, str, str]],
    seed: int,
    index: int,
) -> Trial:
    number, task, robot = jobs[index]
    return trial(task, meanings[task], robot, seed=seed, number=number, arranged_by=arranging[task])


def _warm_up(meanings: Mapping[str, Clause], jobs: Sequence[tuple[int, str, str]], seed: int) -> None:
    """Have compiled what is compiled once, and made what is kept of a robot, in a room that is not among the jobs."""
    number = 1 + max(job[0] for job in jobs)
    task, robot = jobs[0][1:]
    scene = room_to_perform_in(seed, number).scene(robot)
    perform(scene, Request(meanings[task], ROBOT, TARGET, THING))


# --- As tables of text.


def sheets(found: TrialsFound) -> Iterator[Sheet]:
    """All that was found, as tables."""
    rooms = {each.room.rsplit("-", 1)[0] for each in found.trials}
    groups = [(task, robot) for task in found.tasks for robot in found.robots]
    groups += [("all", robot) for robot in found.robots]
    tallies = {group: Tally.of(found.of(None if group[0] == "all" else group[0], group[1])) for group in groups}
    rows = tuple(
        (*group, *(share.text for share in (each.solvable, each.found, each.clean, each.controllable, each.strict)))
        for group, each in tallies.items()
    )
    yield Sheet(
        f"Tasks performed in {len(rooms)} arrangements of rooms, learned {BY_RULE[found.rule]}",
        ("task", "robot", "solvable", "found of solvable", "second audit clean", "controllable", "strict clause"),
        rows,
        "In brackets: 95 % intervals (Wilson). Audit, controllable and strict: of all plans that were returned.",
    )
    yield Sheet(
        "Is what was performed the task?",
        ("task", "robot", "by its own geometric check", "as in all demonstrations"),
        tuple((*group, each.is_task.text, each.as_shown.text) for group, each in tallies.items()),
        "Lines of sight and distances, which no facts are asked for; what was always so, where a clause says it.",
    )
    times = tuple((*group, *(_seconds(each.cpu_s)), *(_seconds(each.refusal_s))) for group, each in tallies.items())
    header = ("task", "robot", "found: median", "95 %", "refused: median", "most")
    yield Sheet("Seconds of the processor for a request", header, times)
    yield _gates(found)
    faults = Counter(_kind(each, fault) for each in found.trials for fault in each.faults)
    if faults:
        listed = tuple((kind, str(count)) for kind, count in faults.most_common(15))
        yield Sheet("What the second auditor finds in returned plans", ("fault", "times"), listed)


def _seconds(pair: tuple[float, float]) -> tuple[str, str]:
    low, high = (NONE if math.isnan(each) else f"{each:.1f}" for each in pair)
    return low, high


def _gates(found: TrialsFound) -> Sheet:
    """Where requests that can be solved were refused."""
    gates = tuple(GATES)
    rows = []
    for task in found.tasks:
        for robot in found.robots:
            missed = Counter(each.gate for each in found.of(task, robot) if each.solvable and not each.found)
            rows.append((task, robot, *(str(missed[gate]) for gate in gates)))
    note = "; ".join(f"{gate}: {text}" for gate, text in GATES.items()) + "."
    return Sheet("Solvable, and no plan: where the planner gave up", ("task", "robot", *gates), tuple(rows), note)


def _kind(trial: Trial, fault: str) -> str:
    """A fault without its figures."""
    return f"{trial.robot}: {fault.partition(':')[0]}"
