"""Learning and explaining: what *give* means after each further demonstration, and why."""

from taskgist import Knowledge, meaning, read_recording, why
from taskgist.learning import clause_of, questions_of
from taskgist.pipeline import explain_all, shipped_recordings


def main() -> None:
    knowledge = Knowledge()
    recordings = [read_recording(path) for path in shipped_recordings("give")]
    for count, explanation in enumerate(explain_all(recordings), start=1):
        knowledge = knowledge.add(explanation)  # demonstrations can be added in any order
        understanding = knowledge.understand("give")
        print(f"after {count}: {len(understanding.kept)} nodes kept")
    print(clause_of(understanding))
    print(meaning(understanding))
    print(why(understanding, "reach.class"))
    print(f"{len(questions_of(understanding))} questions")


if __name__ == "__main__":
    main()
