"""One meaning, three bodies: *hide*, learned from people, done by two robots and a person in another room."""

from math import radians

from taskgist import Knowledge, Scene, read_recording
from taskgist.language import chosen
from taskgist.learning import clause_of
from taskgist.pipeline import explain_all, perform, shipped_room, shipped_study
from taskgist.planning import Request
from taskgist.world import AgentEntry

OTHERS = (AgentEntry("PR2", "pr2", (-1.5, 0.8)), AgentEntry("P1", "human", (-0.62, 0.35), radians(-10.0)))


def main() -> None:
    recordings = [read_recording(path) for path in shipped_study()["hide"]]
    clause = clause_of(Knowledge().add(*explain_all(recordings)).understand("hide"))
    room = Scene.load(shipped_room())  # with Jido and P2 in it
    scenes = {"Jido": room} | {entry.name: room.joined_by(entry)[0] for entry in OTHERS}
    for name, scene in scenes.items():
        outcome = perform(scene, Request(clause, performer=name, target="P2", thing="cup"))
        for performance in outcome.performances:
            clean, strict = performance.audit.clean, performance.strict
            print(f"{chosen(performance.plan)}; audited clean: {clean}, the whole clause holds: {strict}")
        if not outcome.performances:
            print(f"{name} finds no way: {outcome.search.refusals.most_common(1)}")


if __name__ == "__main__":
    main()
