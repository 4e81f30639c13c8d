"""A predicate of your own, added from outside: is the object on top of the white box?"""

from taskgist import Predicate, Stage, explain_recording, read_recording
from taskgist.facts import predicate_subtree
from taskgist.pipeline import shipped_recordings
from taskgist.settings import DEFAULT
from taskgist.world import support_of


def on_white_box(stage: Stage, _agent: str, name: str) -> bool:
    """Called with the stage in the state in question; may also return UNKNOWN, or an Observation with evidence."""
    return support_of(stage, name, DEFAULT.contact) == "white_box"


PREDICATE = Predicate(predicate_subtree("on_white_box"), on_white_box)


def main() -> None:
    for path in shipped_recordings("show"):
        explanation = explain_recording(read_recording(path), predicates=[PREDICATE])
        start, end = (explanation.nodes[f"on_white_box.value.{instant}"].value for instant in (1, 2))
        print(f"{path.stem}: at the start {start}, at the end {end}: {explanation.nodes['on_white_box.class'].value}")


if __name__ == "__main__":
    main()
