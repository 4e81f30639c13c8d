"""Facts from elsewhere: learning from what an annotator wrote down, without any geometry."""

from typing import Any

from taskgist import meaning
from taskgist.facts import STANDARD_TREE, parse_facts
from taskgist.learning import Experience, explain, understand

START: dict[str, Any] = {"see.effort": "Head_Effort", "visibility.score": 0.0008, "placement": "On_Support"}
ENDS: list[dict[str, Any]] = [
    {"see.effort": "No_Effort_Required", "visibility.score": 0.012, "placement": "In_Hand", "motion": "Static"},
    {"see.effort": "No_Effort_Required", "visibility.score": 0.004, "placement": "On_Support", "motion": None},
]


def document(number: int, end: dict[str, Any]) -> dict[str, Any]:
    """One demonstration; null, or a missing attribute, is unknown."""
    return {
        "schema": "taskgist.facts/1",
        "task": "show",
        "demonstration": f"annotated {number}",
        "performing_agent": "P1",
        "target_agent": "P2",
        "target_object": "cup",
        "start": START,
        "end": end,
    }


def main() -> None:
    # Usually: read_facts("demonstration.json"), or taskgist learn demonstration.json
    episodes = [parse_facts(document(number, end), STANDARD_TREE, where="example") for number, end in enumerate(ENDS)]
    experience = Experience.of("show", [explain(episode) for episode in episodes])
    print(meaning(understand(experience)))


if __name__ == "__main__":
    main()
