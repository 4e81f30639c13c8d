"""Judging: whether a final state that nobody has brought about yet would satisfy a goal (9.1).

A state is judged by the very functions that explain a demonstration, as if all had stood still in it for a while
(``observe.attributes.resting_snapshot``). What is cheap is asked first, and after the first literal that fails nothing
more is: most places leave the thing visible, and whoever sees that need not know who could grasp it there. ``lazily``
changes nothing but that; also an effort is only looked for up to the level that decides::

    wanted of see.effort   levels 2 to 5    decided once level 1 is known to do or not
    found                  more than 1      holds; whether 2, 3, 4 or none would do is not asked

**Attention.** Whether the target agent sees the thing without effort hangs on where it looks, which a plan has to
assume: its head ``stays``, or it is turned to the ``thing`` or to the ``performer``'s face, as far as heads turn for a
look (``moving.gaze``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal as OneOf
from typing import NamedTuple, get_args

import numpy as np

from taskgist.common.frozen import FrozenMap
from taskgist.errors import InputError, UnknownNameError
from taskgist.facts.predicates import Predicate
from taskgist.facts.tree import Snapshot
from taskgist.facts.values import UNKNOWN, Observation, Raw
from taskgist.learning.understanding import AnyLiteral
from taskgist.moving.gaze import aimed, subject_place
from taskgist.observe.attributes import LADDERS, RESTING, effort_observations, predicate_observation
from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.goal import Goal, Truth, Wanted
from taskgist.settings import DEFAULT, Following, Settings
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Attention = OneOf["stays", "thing", "performer"]
ATTENTIONS: tuple[Attention, ...] = get_args(Attention)
"""What the target agent may be assumed to look at in the judged state."""
EXACT = Following(place_m=0.0, turn_rad=0.0)
"""States to be judged are no tracker's: each is taken as it is."""


@dataclass(frozen=True)
class Verdict:
    """What was found of a state.

    Attributes:
        holds: Whether all that is wanted holds in it, as far as it can be judged.
        failed: The first literal that surely does not; None if there is none.
        values: What was found, by attribute, as far as somebody looked: a symbol, a score, a status by side. An effort
            is there only if its level is known exactly.
        judge: Of several who are asked, the number of the one who says so.
    """

    holds: Truth
    failed: AnyLiteral | None = None
    values: Mapping[str, Raw] = field(default_factory=FrozenMap)
    judge: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", FrozenMap(self.values))


class EndFails(NamedTuple):
    """Why the end of an action will not do: with an agent where it is then, a literal fails."""

    agent: str
    literal: AnyLiteral

    def __str__(self) -> str:
        return f"with {self.agent} where it is in the end, {self.literal} fails"


Reason = str | EndFails
"""Why an action does not do: in words, or a literal that fails, for which whoever tells it has words."""


class Judge:
    """Judges final states of a scene by a goal.

    Args:
        scene: The scene.
        start: The state in which the task begins. The judged states mostly differ from it by the thing's pose alone;
            others are judged as well, only not as quickly.
        agent: The target agent, from whose perspective all is judged.
        thing: The target object.
        goal: What is wanted.
        settings: All settings.
        predicates: A user's own predicates.
        attention: What the target agent is assumed to look at.
        performer: The performing agent; only needed if the target agent looks at it.
        watched: The thing that the target agent is assumed to look at, where that is another one.

    Raises:
        UnknownNameError: There is no such agent, object or kind of attention, or nobody observes what is wanted.
        InputError: The target agent shall look at a performer that is not named.
    """

    def __init__(
        self,
        scene: Scene,
        start: State,
        agent: str,
        thing: str,
        goal: Goal,
        settings: Settings = DEFAULT,
        predicates: Iterable[Predicate] = (),
        *,
        attention: Attention = "stays",
        performer: str | None = None,
        watched: str | None = None,
    ) -> None:
        if attention not in ATTENTIONS:
            raise UnknownNameError("kind of attention", attention, ATTENTIONS)
        if attention == "performer" and performer is None:
            raise InputError("nobody to look at", field="performer", hint="name the performing agent")
        self._agent, self._thing = scene.agent(agent), thing
        scene.object_body(thing)
        self._looks_at = {"stays": None, "thing": watched or thing, "performer": performer}[attention]
        if performer is not None:
            scene.agent(performer)
        self.goal, self._settings = goal, settings
        self._predicates = {each.subtree.attribute.name: each for each in predicates if each.observe is not None}
        for wanted in goal.wanted:
            if not (_ability(wanted.attribute) or wanted.attribute in (*RESTING, *self._predicates)):
                raise self._unobserved(wanted.attribute)
        self._stage = Stage(scene, start)
        self._efforts = SceneEfforts(Stage(scene, self.assumed(start)), replace(settings, following=EXACT))

    def verdict(self, state: State, *, lazily: bool = True) -> Verdict:
        """Whether a final state satisfies the goal.

        Args:
            state: The state, of the judge's scene.
            lazily: Whether to stop at the first literal that fails, and to look for efforts only as far as they matter.
        """
        failed = self.goal.impossible[0].literals[0] if self.goal.impossible else None
        state, unknown, values = self.assumed(state), False, dict[str, Raw]()
        for wanted in () if failed and lazily else self.goal.wanted:
            truths, found = self._found(state, wanted, lazily)
            values.update({name: each.value for name, each in found.items()})
            unknown = unknown or UNKNOWN in truths
            if failed is None and False in truths:
                failed = wanted.literals[truths.index(False)]
            if failed and lazily:
                break
        return Verdict(False if failed else UNKNOWN if unknown else True, failed, values)

    def observed(self, state: State, attribute: str) -> Observation[Raw]:
        """What an attribute is in a final state, with its evidence: who occludes, what blocks, the nearest miss.

        Args:
            state: The state, of the judge's scene.
            attribute: Name of an attribute, such as ``"see.effort"``.

        Raises:
            UnknownNameError: Nobody observes such an attribute in a state.
        """
        state, ability = self.assumed(state), _ability(attribute)
        if ability is None:
            return self._observed(state, attribute)
        self._efforts.update(state)
        effort = self._efforts.effort(self._agent.name, self._thing, ability)
        found = effort_observations(effort, self._settings)
        if attribute not in found:
            raise self._unobserved(attribute)
        return found[attribute]

    def assumed(self, state: State) -> State:
        """A final state as it is judged: the target agent's head turned to what it is assumed to look at.

        Who holds what is left to distances: nothing slips where all stands still. A head that cannot turn stays.
        """
        state = state.with_holding(None)
        pan, tilt = self._agent.profile.pan, self._agent.profile.tilt
        if self._looks_at is None or pan is None or tilt is None:
            return state
        place = subject_place(self._stage.show(state), self._looks_at)
        ((panned, tilted),) = aimed(self._stage, self._agent, np.array(state.qpos)[None], place[None])
        joints = self._agent.joints
        return state.replace({joints[pan.joint]: panned, joints[tilt.joint]: tilted})

    def _found(self, state: State, wanted: Wanted, lazily: bool) -> tuple[tuple[Truth, ...], Snapshot]:
        """Whether the literals on an attribute hold in a state, and what was found out about it for sure."""
        ability = _ability(wanted.attribute)
        if ability is None:
            observed = self._observed(state, wanted.attribute)
            return wanted.truths_of(observed.value), {wanted.attribute: observed}
        if state is not self._efforts.state:
            self._efforts.update(state)
        if lazily and wanted.decisive_level is not None:
            level = self._efforts.level(self._agent.name, self._thing, ability, up_to=wanted.decisive_level)
            # A level beyond the decisive one is told as the next one, which has the same truths.
            symbol = UNKNOWN if level is None else LADDERS[ability][level]
            truths = wanted.truths_of(symbol)
            if level is None or False in truths or UNKNOWN not in truths:
                exact = level is None or level <= wanted.decisive_level
                return truths, {wanted.attribute: Observation(symbol)} if exact else {}
        effort = self._efforts.effort(self._agent.name, self._thing, ability)
        found = effort_observations(effort, self._settings, explained=False)
        return wanted.aspect.truths(found), found

    def _observed(self, state: State, attribute: str) -> Observation[Raw]:
        """An attribute that needs no search, in a state."""
        stage = self._stage.show(state)
        if attribute in RESTING:
            return RESTING[attribute](stage, self._agent.name, self._thing, self._settings)
        if attribute not in self._predicates:
            raise self._unobserved(attribute)
        return predicate_observation(self._predicates[attribute], stage, self._agent.name, self._thing)

    def _unobserved(self, attribute: str) -> UnknownNameError:
        efforts = (f"{ability}.{part}" for ability in ABILITIES for part in ("effort", "state", "action"))
        return UnknownNameError(
            "attribute that is observed in a state", attribute, (*RESTING, *efforts, *self._predicates)
        )


def _ability(attribute: str) -> Ability | None:
    """The ability whose effort, state or action an attribute is; None for other attributes."""
    return next((ability for ability in ABILITIES if attribute.partition(".")[0] == ability), None)
