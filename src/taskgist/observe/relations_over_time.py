"""Relations over time: each confirmed as the other facts over time are, and who approaches what.

Of a whole recording it can be asked at once; live it takes one state after another, behind an observer that does::

    relations = RelationsOverTime(Observer(recording.scene, recording), recording)
    relations.of("P1", "cup")["gaze"]            # intervals: what P1 looked at, from when to when
    relations.at("P1", "cup", 2.5)["sight"]
"""

from __future__ import annotations

import math
from functools import cache, lru_cache, partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.frozen import Json
from taskgist.common.workers import Progress, silent
from taskgist.facts.values import UNKNOWN, Observation, Unknown
from taskgist.observe.attention import Gaze, gaze, looks_at, mutual_gaze, sight
from taskgist.observe.frames import KEPT_FRAMES, Confirmed, FrameSequence, Hysteresis, Interval, velocity
from taskgist.observe.observer import Observer
from taskgist.observe.relations import carried_by, direction, distance, facing, middle_of, touching
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage
from taskgist.world.state import Frames, State

Symbol = str | bool | None
"""A relation's value over time; None is unknown."""
Relations = dict[str, Observation[str | bool | Unknown]]
"""Relations of one moment, by name."""
OF_A_MOMENT = ("sight", "distance", "direction", "facing", "touching", "carried_by", "gaze", "looked_at_by")
WITH_ANOTHER = ("facing", "mutual_gaze", "joint_attention")
"""Names of relations, in the order in which they are told."""
NOTHING, NOBODY, NO_SIDE = "nothing", "nobody", "none"


def relations_of(stage: Stage, agent: str, name: str, settings: Settings = DEFAULT) -> Relations:
    """All relations of one moment between an agent and an object.

    Args:
        stage: The scene in a state.
        agent: From whose view.
        name: The object.
        settings: All settings.

    Returns:
        Observations with their evidence by name: ``sight``, ``distance``, ``direction``, ``facing``, ``touching``,
        ``carried_by``, ``gaze`` (what the agent looks at), ``looked_at_by`` (who looks at the object); and with each
        other agent by its name, as in ``facing P2``: ``facing``, ``mutual_gaze``, ``joint_attention`` (what both look
        at).

    Raises:
        UnknownNameError: There is no such agent or object.
    """
    carriers, line = carried_by(stage, name, settings), sight(stage, agent, name, settings)
    far, where = distance(stage, agent, name, settings), direction(stage, agent, name, settings=settings)
    look, unknown = gaze(stage, agent, settings), _observed(None)
    found = {
        "sight": _observed(line.value, share=line.share, blockers=dict(line.blockers)) if line else unknown,
        "distance": _observed(far.value, metres=far.metres) if far else unknown,
        "direction": _observed(", ".join(where.sides) or NO_SIDE, bearing_rad=where.bearing_rad) if where else unknown,
        "facing": _observed(facing(stage, agent, name, settings)),
        "touching": _observed(touching(stage, agent, name, settings)),
        "carried_by": unknown if carriers is None else _observed(", ".join(carriers) or NOBODY),
        "gaze": _observed(look.target or NOTHING, off_rad=look.off_rad, **_assumed(stage, agent)) if look else unknown,
        "looked_at_by": _observed(_lookers(stage, name, settings)),
    }
    for other in stage.scene.agents:
        if other != agent:
            found[f"facing {other}"] = _observed(facing(stage, agent, other, settings))
            found[f"mutual_gaze {other}"] = _observed(mutual_gaze(stage, agent, other, settings))
            found[f"joint_attention {other}"] = _observed(_shared(look, gaze(stage, other, settings)))
    return found


def _observed(value: str | bool | None, **evidence: Json) -> Observation[str | bool | Unknown]:
    return Observation(UNKNOWN if value is None else value, evidence)


def _assumed(stage: Stage, agent: str) -> dict[str, Json]:
    """What was assumed of an agent's eyes."""
    turn = stage.state.eyes.get(agent)
    return {} if turn is None or turn.towards is None else {"eyes_towards": turn.towards, "eyes_rad": turn.turned_rad}


def _lookers(stage: Stage, name: str, settings: Settings) -> str | None:
    """Who looks at an object; unknown where nobody is known to, and somebody may."""
    look = {agent: looks_at(stage, agent, name, settings) for agent in stage.scene.agents}
    lookers = ", ".join(agent for agent, looks in look.items() if looks)
    return lookers or (None if None in look.values() else NOBODY)


def _shared(one: Gaze | None, other: Gaze | None) -> str | None:
    """What both look at."""
    if one is None or other is None:
        known = one or other
        return NOTHING if known and known.target is None else None
    return one.target if one.target and one.target == other.target else NOTHING


class RelationsOverTime:
    """Confirms relations over time.

    Args:
        observer: Tells who holds what in these frames; live, each state is appended to it first.
        frames: All frames, such as a recording. Where they are left out, they come one by one: see ``append``.
        settings: Distances, angles, speeds and durations.
        progress: Told how far it is, while frames are looked at.
    """

    def __init__(
        self,
        observer: Observer,
        frames: Frames | None = None,
        settings: Settings = DEFAULT,
        *,
        progress: Progress = silent,
    ) -> None:
        self._progress = progress
        self.scene, self._observer, self._settings = observer.scene, observer, settings
        timing, delay_s = settings.timing, settings.carrying.delay_s
        # by then the observer has confirmed who holds what in a settled frame, and where eyes look
        holding_s = 2 * timing.minimum_s + max(timing.motion_window_s, 2 * delay_s) + 2 * settings.gaze.before_s
        self._frames = FrameSequence(max(settings.relations.approach_window_s, holding_s), frames)
        self._stage = Stage(self.scene)
        self._moment = lru_cache(KEPT_FRAMES)(self._moment_in)
        self._speed_m_s = lru_cache(KEPT_FRAMES)(self._speed_in)
        self._approaches = cache(lambda agent, name: Hysteresis(partial(self._goes_on, agent, name)))
        self._rows = cache(self._rows_of)

    def append(self, state: State) -> None:
        """Take the next frame.

        Raises:
            RecordingError: It is not later than the last one, or no more frames were to come.
        """
        self._frames.append(state)

    def finish(self) -> None:
        """Say that no more frames will come: the last ones count, too."""
        self._frames.finish()

    def of(self, agent: str, name: str) -> dict[str, tuple[Interval[Symbol], ...]]:
        """The intervals of each relation between an agent and an object: those of a moment, and who is approached.

        ``approaching`` is the object, ``approaching P2`` another agent.

        Raises:
            UnknownNameError: There is no such agent or object.
        """
        return {row: confirmed.intervals for row, confirmed in self._checked(agent, name).items()}

    def at(self, agent: str, name: str, time_s: float) -> dict[str, Symbol]:
        """The same as confirmed at a time; None is unknown, or not confirmed yet.

        Raises:
            UnknownNameError: There is no such agent or object.
        """
        return {row: confirmed.at(time_s) for row, confirmed in self._checked(agent, name).items()}

    def _checked(self, agent: str, name: str) -> dict[str, Confirmed[Symbol]]:
        self.scene.agent(agent)
        self.scene.object_body(name)
        return self._rows(agent, name)

    def _rows_of(self, agent: str, name: str) -> dict[str, Confirmed[Symbol]]:
        together: list[Confirmed[Symbol]] = []
        others = [other for other in self.scene.agents if other != agent]
        names = [*OF_A_MOMENT, *(f"{row} {other}" for other in others for row in WITH_ANOTHER)]
        raw = {row: partial(self._value, agent, name, row) for row in names}
        raw["approaching"] = partial(self._approaching, agent, name)
        raw |= {f"approaching {other}": partial(self._approaching, agent, other) for other in others}
        minimum_s = self._settings.timing.minimum_s
        return {row: Confirmed(self._frames, of, minimum_s, together=together) for row, of in raw.items()}

    # What is so in a single frame, before time confirms it:

    def _value(self, agent: str, name: str, row: str, index: int) -> Symbol:
        value = self._moment(agent, name, index)[row].value
        return None if value is UNKNOWN else value

    def _moment_in(self, agent: str, name: str, index: int) -> Relations:
        self._progress("relating", (index + 1) / len(self._frames.times_s))
        state = self._observer.as_confirmed(self._frames.state(index))
        return relations_of(self._stage.show(state), agent, name, self._settings)

    def _approaching(self, agent: str, name: str, index: int) -> Symbol:
        """Whether an agent itself moves towards a thing and gets nearer to it, as it does not to what it carries."""
        if self._speed_m_s(agent, name, index) is None:
            return None
        return self._approaches(agent, name).at(index)

    def _goes_on(self, agent: str, name: str, index: int, before: bool) -> bool:
        speed_m_s, limits = self._speed_m_s(agent, name, index), self._settings.relations
        return speed_m_s is not None and speed_m_s > (limits.approach_stop_m_s if before else limits.approach_start_m_s)

    def _speed_in(self, agent: str, name: str, index: int) -> float | None:
        """The lesser of how fast the agent goes towards a thing and how fast it gets nearer, metres per second."""
        state, relations = self._frames.state(index), self._settings.relations
        if not state.known([agent, name]):
            return None
        window = self._frames.window(index, relations.approach_window_s)
        tracked = [each for each in window if self._frames.state(each).known([agent, name])]
        times_s = [self._frames.times_s[each] for each in tracked]
        places = np.array([self._places(agent, name, each) for each in tracked])
        own, ways = velocity(times_s, places[:, 0]), places[:, 1] - places[:, 0]
        gaining = velocity(times_s, np.linalg.norm(ways, axis=1)[:, None])
        if own is None or gaining is None:
            return None
        way = ways[tracked.index(index)]
        way_m = math.hypot(*way)
        return 0.0 if way_m <= relations.overhead_m else min(float(own @ way) / way_m, -float(gaining[0]))

    def _places(self, agent: str, name: str, index: int) -> Array:
        """Where agent and thing are on the floor in a frame, metres, (2, 2)."""
        stage = self._stage.show(self._frames.state(index))
        return np.stack((middle_of(stage, agent)[:2], middle_of(stage, name)[:2]))
