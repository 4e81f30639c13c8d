"""The search for the least effort (5.1.5, Eq. 8 and 9): effort levels from least to most, until one gives the ability.

Within a level, candidates come from the least amount to the greatest. The first amount at which the ability holds
without a collision is the level's answer; of several states with equal amounts the one of least cost is taken (most
pixels, nearest shoulder), and between two hands that are equally near the right one. The levels are nested: what a
level gives is not lost at a higher one, for a higher one is only asked when all lower ones fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

from taskgist.common.arrays import Array
from taskgist.errors import UnknownNameError
from taskgist.perspective.candidates import Candidate, Candidates
from taskgist.perspective.effort import (
    ABILITIES,
    LEAN,
    NO_ACTION,
    NO_KNOWN_ACTION,
    NO_KNOWN_LEVEL,
    PAN,
    SIT,
    STAND,
    TILT,
    TURN,
    Ability,
    Amount,
    Blocking,
    Effort,
    Evidence,
    Miss,
    Reason,
    Visibility,
    assumed_gaze,
    nearest_miss,
)
from taskgist.perspective.grasp import Grasp
from taskgist.perspective.reach import Reach
from taskgist.perspective.see import See
from taskgist.perspective.target import Target
from taskgist.perspective.viewpoint import FindMiss, Hit, Judge, Screening, Viewpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.profile import Posture
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

JUDGES: Mapping[Ability, Callable[[Viewpoint, Target], Judge]] = {"see": See, "reach": Reach, "grasp": Grasp}
HEAD = "head"
FREE: Mapping[Ability, str] = {"see": "in the gaze cone", "reach": "held", "grasp": "held"}
"""Why nothing needs to be done."""


# --- One effort level.

POSTURES = 3
"""The level from which an agent takes other postures: what rests on its body is not where it was any longer."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A candidate from which an ability holds, free of collisions, and how it does."""

    candidate: Candidate
    hit: Hit

    @cached_property
    def state(self) -> State:
        """The attained state."""
        angles = self.hit.angles_rad
        return self.candidate.state.replace(angles) if angles else self.candidate.state

    @property
    def actions(self) -> tuple[str, ...]:
        """Virtual actions in order."""
        return (*self.candidate.actions, *self.hit.actions)

    @property
    def amount(self) -> Amount:
        """How much of them."""
        return replace(self.candidate.amount, head_rad=self.hit.head_rad)

    @property
    def order(self) -> tuple[object, ...]:
        """Least amount first, then least cost, then the right hand."""
        return (self.amount.key, self.hit.order)


def least(here: Viewpoint, judge: Judge, level: int, target: Array) -> Solution | FindMiss:
    """The least amount of an effort level that gives an ability, or why none does.

    Args:
        here: Whose ability, and from where.
        judge: The ability towards an object.
        level: Effort level, 0 to 4.
        target: The object's middle, metres, (3,).
    """
    if level == 0:
        result = judge.without_effort()
        return Solution(here.candidates.current, result) if isinstance(result, Hit) else result
    if level >= POSTURES and judge.target.name in here.on_body:
        return partial(Miss, Reason.NO_POSTURE, f"rests on {here.agent.name}, and would not stay there")
    misses: list[FindMiss] = []
    screenings: list[Screening] = []
    if judge.brief and (judge.hopeless or judge.passes_over(level)):
        return lambda: UNTOLD
    for candidates in here.candidates.of_level(level, target):
        if judge.brief and judge.hopeless:
            break
        screening = judge.screen(candidates)
        screenings.append(screening)
        for group in _hopeful(candidates, screening):
            found = [each for index in group for each in _free(here, screening, index, candidates[index], misses)]
            if found:
                best = min(found, key=lambda each: each.order)
                here.recorder.found_after(best.amount.moved_m)
                return best
    return partial(_nearest, here, level, misses, screenings)


UNTOLD = Miss(Reason.UNTRACKED, "nobody asked")
"""Why an ability does not hold where only the level is asked for."""


def _hopeful(candidates: Candidates, screening: Screening) -> Iterator[list[int]]:
    """Candidates from which the ability may hold, those of equal amount together, the least amount first."""
    count = len(candidates)
    first = screening.next(0, count)
    while first < count:
        end = int(candidates.ends[first])
        group, index = [first], screening.next(first + 1, end)
        while index < end:
            group.append(index)
            index = screening.next(index + 1, end)
        yield group
        first = screening.next(end, count)


def _free(
    here: Viewpoint, screening: Screening, index: int, candidate: Candidate, misses: list[FindMiss]
) -> Iterator[Solution]:
    """The best solution from a candidate that respects the constraints, if any; notes why others do not count."""
    for result in screening.results(index):
        if not isinstance(result, Hit):
            misses.append(result)
            continue
        solution = Solution(candidate, result)
        blocking = here.collisions_of(candidate).blocking(solution.state)
        if blocking is None:
            yield solution
            return
        misses.append(partial(_collision, solution.actions, blocking))
        if blocking.part != HEAD:
            return  # hits from one candidate differ in the head only


def _collision(actions: tuple[str, ...], blocking: Blocking) -> Miss:
    return Miss(Reason.COLLISION, f"{' + '.join(actions)} is blocked: {blocking}", hindrance=blocking)


def _nearest(here: Viewpoint, level: int, misses: list[FindMiss], screenings: list[Screening]) -> Miss:
    """The nearest of all misses of a level."""
    found = [find() for find in misses] + [miss for each in screenings if (miss := each.miss()) is not None]
    return nearest_miss(found) if found else here.candidates.why_none(level)


# --- All levels.


def least_effort(stage: Stage, agent: str, name: str, ability: Ability, settings: Settings = DEFAULT) -> Effort:
    """The least effort with which an agent sees, reaches or grasps an object.

    Whoever asks several questions about one state asks ``SceneEfforts``, or makes a ``Viewpoint`` once.

    Args:
        stage: The scene in a state.
        agent: Whose ability.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        settings: All settings.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
    """
    return effort_from(Viewpoint(stage, agent, settings), name, ability)


def effort_from(here: Viewpoint, name: str, ability: Ability, *, explained: bool = False) -> Effort:
    """As ``least_effort``, from a viewpoint, whose recorder then holds what this answer depends on.

    Args:
        here: Whose ability, and from where.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        explained: Whether evidence is found at once. Otherwise whoever asks the effort for it has it found anew, on a
            stage of its own: an effort is a value, whatever becomes of the stage.

    Raises:
        UnknownNameError: There is no such object or ability.
    """
    with here.stage.showing(here.state):
        here.recorder.begin()
        level, solution, misses = _searched(here, name, ability, brief=not explained)
        if explained:
            untried = here.candidates.untried if level == NO_KNOWN_LEVEL else None
            evidence = replace(_evidence(ability, level, solution, misses), untried=untried)
            return _effort(here, name, ability, level, solution, lambda: evidence)
    asked = (here.stage.scene, here.state, here.agent.name, here.settings, here.actions, name, ability)
    return _effort(here, name, ability, level, solution, partial(_evidence_anew, *asked))


def able(
    stage: Stage, agent: str, name: str, ability: Ability, *, max_level: int, settings: Settings = DEFAULT
) -> bool | None:
    """Whether an agent sees, reaches or grasps an object with no more than an effort level.

    Args:
        stage: The scene in a state.
        agent: Whose ability.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        max_level: The greatest effort level allowed, 0 to 4.
        settings: All settings.

    Returns:
        None where no level is known to give the ability and one of them is unknown.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
    """
    here = Viewpoint(stage, agent, settings)
    with stage.showing(here.state):
        judge = _judge(here, name, ability)
        if judge is None:
            return None
        target = here.target(name).middle
        levels = range(min(max_level, NO_KNOWN_LEVEL - 1) + 1)
        known = [level for level in levels if judge.unknown(level) is None]
        if any(isinstance(least(here, judge, level, target), Solution) for level in known):
            return True
        return False if len(known) == len(levels) else None


def level_from(here: Viewpoint, name: str, ability: Ability, *, up_to: int) -> int | None:
    """The level of ``effort_from``, looked for only as far as somebody wants to know it.

    Args:
        here: Whose ability, and from where.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        up_to: The greatest level that is told exactly, −1 to 4; what is greater is told as the next one.

    Returns:
        None where ``effort_from`` has none, whatever was asked.

    Raises:
        UnknownNameError: There is no such object or ability.
    """
    with here.stage.showing(here.state):
        here.recorder.begin()
        level = _searched(here, name, ability, brief=True, up_to=up_to)[0]
    return None if level is None else min(level, up_to + 1)


def _searched(
    here: Viewpoint, name: str, ability: Ability, *, brief: bool, up_to: int = NO_KNOWN_LEVEL
) -> tuple[int | None, Solution | None, list[FindMiss]]:
    """The level found, None if unknown; how it is attained, if it is; and why not with less, level by level.

    Beyond ``up_to`` levels are only tried where one of them may turn out to be unknown.
    """
    judge, misses = _judge(here, name, ability), list[FindMiss]()
    if judge is None:
        why = "has no shape" if name in here.stage.scene.shapeless else "not tracked"
        return None, None, [partial(Miss, Reason.UNTRACKED, f"{name} {why}")]
    judge.brief = brief
    target = here.target(name).middle
    for level in range(NO_KNOWN_LEVEL):
        unknown = judge.unknown(level)
        if level > up_to and not any(map(judge.unknown, range(level, NO_KNOWN_LEVEL))):
            return level, None, misses
        if unknown is not None:
            return None, None, [*misses, partial(Miss, Reason.UNTRACKED, unknown)]
        result = least(here, judge, level, target)
        if isinstance(result, Solution):
            return level, result, misses
        misses.append(result)
    return NO_KNOWN_LEVEL, None, misses


def _judge(here: Viewpoint, name: str, ability: Ability) -> Judge | None:
    """The ability's judge; None if the object was not tracked."""
    if ability not in JUDGES:
        raise UnknownNameError("ability", ability, ABILITIES)
    here.stage.scene.object_body(name)
    return JUDGES[ability](here, here.target(name)) if here.state.known([name]) else None


def _effort(
    here: Viewpoint,
    name: str,
    ability: Ability,
    level: int | None,
    solution: Solution | None,
    find_evidence: Callable[[], Evidence],
) -> Effort:
    """An answer as a value; at level 5, and if unknown, the agent stays as it is."""
    profile, joints, now = here.agent.profile, here.agent.joints, here.state.qpos
    axes = {PAN: profile.pan, TILT: profile.tilt, TURN: profile.turn, LEAN: profile.lean}
    attained = (solution.state if solution else here.state).qpos
    angles = {action: (axis.joint, float(attained[joints[axis.joint]])) for action, axis in axes.items() if axis}
    actions: tuple[str, ...] = () if level is None else (NO_KNOWN_ACTION,)
    if solution is not None:
        actions = solution.actions or (NO_ACTION,)
    return Effort(
        ability=ability,
        agent=here.agent.name,
        target=name,
        level=level,
        actions=actions,
        amount=solution.amount if solution else None,
        joints_rad=dict(angles.values()),
        posture=_posture(here, actions),
        turns_rad={
            action: angle - float(now[joints[joint]]) for action, (joint, angle) in angles.items() if action in actions
        },
        find_evidence=find_evidence,
    )


def _posture(here: Viewpoint, actions: tuple[str, ...]) -> Posture | None:
    if STAND in actions:
        return "standing"
    return "sitting" if SIT in actions else here.posture


def _evidence(ability: Ability, level: int | None, solution: Solution | None, misses: list[FindMiss]) -> Evidence:
    """What was found, and why not with less; where nothing was, the reason says what stands in the way."""
    found = tuple(find() for find in misses)
    told = nearest_miss(found) if found else None
    if level is None:
        told = found[-1]
    attained = solution.hit.find_evidence() if solution else None
    if told is not None:
        return Evidence(told.text, found, told, attained)
    reason = FREE[ability]
    if isinstance(attained, Visibility) and attained.eyes_towards is not None:
        reason += f", {assumed_gaze(attained.eyes_towards, attained.eyes_rad)}"
    return Evidence(reason, found, None, attained)


def _evidence_anew(
    scene: Scene,
    state: State,
    agent: str,
    settings: Settings,
    actions: frozenset[str],
    name: str,
    ability: Ability,
) -> Evidence:
    """The evidence of an effort, found again."""
    here = Viewpoint(Stage(scene, state), agent, settings, actions=actions)
    return effort_from(here, name, ability, explained=True).evidence
