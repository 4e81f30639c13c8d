"""Measure who is said to hold what, and when; tables for docs/research/holding.md: ``python -m tools.holding_page``."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from taskgist.observe import Carrying, FrameSequence, Observer
from taskgist.observe.evidence import EvidenceOf, Tracked
from taskgist.observe.holding import Carrier, likeliest
from taskgist.pipeline import shipped_recordings, shipped_study
from taskgist.recognition import grips_of, propose_label
from taskgist.recording import Recording, read
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist_lab.paper import check_grips
from tests.importing.noisy_takes import CHANGES_S, take
from tools.markdown import filled, header, row

PAGE = Path("docs/research/holding.md")
HANDS_CM = (1, 2, 3, 5)
CORRELATED_S = (0.0, 0.15, 0.4)
"""How long errors of hands last: 0 is white noise."""
SEEDS = range(100, 104)
"""Of the takes of each kind of noise: others than those that the weights were tried on."""
CLOSE_S = 0.3


@dataclass
class Found:
    """What came out of the takes of one kind of noise.

    Attributes:
        changes_s: When the thing is said to change hands, minus when it does, in seconds; NaN where it is not said.
        ends_s: The same of the ends of the proposed labels.
        reversed: How many of them have other roles.
    """

    changes_s: list[float] = field(default_factory=list)
    ends_s: list[float] = field(default_factory=list)
    reversed: int = 0


def main() -> None:
    """Measure, rewrite the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.parse_args()
    takes = {
        (hands_cm, correlated_s): [noisy(hands_cm, correlated_s, seed) for seed in SEEDS]
        for hands_cm in HANDS_CM
        for correlated_s in CORRELATED_S
    }
    found = {kind: judged(recordings) for kind, recordings in takes.items()}
    shipped = [read(path) for path in (*shipped_recordings("give"), *sum(shipped_study().values(), ()))]
    parts: Mapping[str, Iterator[str]] = {
        "forces": forces(shipped[:4]),
        "takes": table(found),
        "live": live_lines({"shipped recordings": shipped, "noisy takes": [*chain.from_iterable(takes.values())]}),
        "cost": cost_lines(shipped),
    }
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts), encoding="utf-8")


def noisy(hands_cm: int, correlated_s: float, seed: int) -> Recording:
    """One noisy take."""
    with TemporaryDirectory() as folder:
        return take(Path(folder), hands_m=hands_cm / 100, correlated_s=correlated_s, seed=seed)


def judged(recordings: Sequence[Recording]) -> Found:
    """When the mug of some takes is said to change hands, and what labels are proposed."""
    found = Found()
    for recording in recordings:
        observer = Observer(recording.scene, recording)
        label = propose_label(recording, observer, task="give")
        found.ends_s.append(label.end_s - CHANGES_S)
        found.reversed += (label.performing_agent, label.target_agents) != ("P1", ("P2",))
        grips = grips_of(observer, "mug")
        lets_go_s = [grip.end_s for grip in grips if grip.agent == "P1"]
        takes_s = [grip.start_s for grip in grips if grip.agent == "P2"]
        known = bool(lets_go_s and takes_s)
        found.changes_s.append((max(lets_go_s) + min(takes_s)) / 2 - CHANGES_S if known else np.nan)
    return found


def forces(recordings: Sequence[Recording]) -> Iterator[str]:
    """Geometry minus force, for each event of the real handovers; those in the air count."""
    yield from header("", "giver takes", "taker takes", "giver lets go", "taker lets go")
    in_air: list[float] = []
    for recording in recordings:
        checks = check_grips(recording, Observer(recording.scene, recording), "baton")
        by_event = {(check.agent, check.event): check for check in checks}
        in_air += [abs(check.difference_ms) for check in checks if not check.supported]
        events = (("P1", "takes"), ("P2", "takes"), ("P1", "lets go"), ("P2", "lets go"))
        yield row(recording.name, *(f"{by_event[event].difference_ms:+.0f}" for event in events))
    yield ""
    differ = f"{np.mean(in_air):.0f} ms on average, {max(in_air):.0f} at most"
    yield f"In the air ({len(in_air)} events) they differ by {differ}."


def table(found: Mapping[tuple[int, float], Found]) -> Iterator[str]:
    """Each kind of noise, and all together."""
    yield from header("hands", "errors last", "takes", "reversed", "change within 0.3 s", "label's end within 0.3 s")
    for (hands_cm, correlated_s), each in found.items():
        lasts = f"{correlated_s:g} s" if correlated_s else "no time"
        yield row(f"{hands_cm} cm", lasts, *_figures([each]))
    yield row("all", "", *_figures(list(found.values())))


def _figures(found: Sequence[Found]) -> tuple[object, ...]:
    changes_s, ends_s = (np.concatenate(each) for each in ([f.changes_s for f in found], [f.ends_s for f in found]))
    shares = (f"{100 * np.mean(np.abs(values) <= CLOSE_S + 1e-6):.0f} %" for values in (changes_s, ends_s))
    return len(ends_s), sum(each.reversed for each in found), *shares


def live_lines(recordings: Mapping[str, Sequence[Recording]]) -> Iterator[str]:
    """In how many frames the same is said half a second later as of the whole recording."""
    yield from header("", "recordings", "frames", "the same live")
    for what, some in recordings.items():
        same = [
            one == other
            for recording in some
            for one, other in zip(carriers(recording, whole=True), carriers(recording, whole=False), strict=True)
        ]
        yield row(what, len(some), len(same), f"{100 * np.mean(same):.2f} %")


def carriers(recording: Recording, *, whole: bool) -> list[Carrier]:
    """What carries the first of the recording's objects that its label names, or that there is, in each frame."""
    frames = FrameSequence(2 * DEFAULT.carrying.delay_s, recording if whole else None)
    if not whole:
        for index in range(len(recording)):
            frames.append(recording.state(index))
        frames.finish()
    carrying = Carrying(Stage(recording.scene), frames, DEFAULT)
    return [carrying.carrier(index, thing_of(recording)) for index in range(len(recording))]


def thing_of(recording: Recording) -> str:
    """The object that a recording is about."""
    return recording.label.target_objects[0] if recording.label else recording.scene.objects[0]


def cost_lines(recordings: Sequence[Recording]) -> Iterator[str]:
    """Processor time of the inference, and of what it is made from, for each recording."""
    inferred_ms, looked_ms, frames = list[float](), list[float](), list[int]()
    for recording in recordings:
        tracked = Tracked(Stage(recording.scene), FrameSequence(0.0, recording), DEFAULT)
        evidence = EvidenceOf(tracked, thing_of(recording))
        start_s = time.process_time()
        seen = [evidence.at(index) for index in range(len(recording))]
        looked_s = time.process_time()
        likeliest(seen, DEFAULT.carrying)
        inferred_ms.append(1000 * (time.process_time() - looked_s))
        looked_ms.append(1000 * (looked_s - start_s))
        frames.append(len(recording))
    yield from header("", "frames", "evidence", "inference")
    for what, share in (("median", 0.5), ("most", 1.0)):
        cells = (f"{np.quantile(values, share):.0f} ms" for values in (looked_ms, inferred_ms))
        yield row(what, f"{np.quantile(frames, share):.0f}", *cells)


if __name__ == "__main__":
    main()
