"""A recording's facts: who holds what when, and what the handover changed for the taker."""

from taskgist import Observer, explain_recording, read_recording
from taskgist.facts import STANDARD_TREE
from taskgist.pipeline import label_of, shipped_recordings
from taskgist.recognition import grips_of


def main() -> None:
    recording = read_recording(shipped_recordings("give")[0])
    label = label_of(recording)
    observer = Observer(recording.scene, recording)
    for grip in grips_of(observer, label.target_object):
        print(f"{grip.agent} holds the {label.target_object}, {grip.side} hand, {grip.start_s:.2f}-{grip.end_s:.2f} s")
    for interval in observer.placement(label.target_object).intervals:
        print(f"{interval.start_s:.2f}-{interval.end_s:.2f} s: {interval.value.symbol} {', '.join(interval.value.by)}")
    explanation = explain_recording(recording, observer=observer)
    print(f"what changed for {label.target_agent} between {label.start_s:.2f} and {label.end_s:.2f} s:")
    for node in STANDARD_TREE.nodes:
        if node.level == 2:
            print(f"  {node.title} = {explanation.nodes[node.name].value}")


if __name__ == "__main__":
    main()
