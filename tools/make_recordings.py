"""Make the shipped recordings anew: real handovers from the KTH data, the paper's study from scripted demonstrators.

    python tools/make_recordings.py --kth FOLDER_OF_THE_KTH_DATA

Without ``--kth`` only the simulated ones are made. The KTH data is described in docs/research/recordings.md.
"""

from __future__ import annotations

import argparse
import shutil
from dataclasses import replace
from pathlib import Path

from taskgist.importing import import_recording, load_mapping
from taskgist.observe import Observer
from taskgist.recognition import propose_label
from taskgist.recording import Label, Recording, write
from taskgist_lab.paper import STUDY, check_grips
from taskgist_lab.paper.grip_forces import GRIP_N

DATA = Path(__file__).parent.parent / "src" / "taskgist" / "data"
HANDOVERS = {
    "handover_1": "handovers_P1_S1_handover_2",
    "handover_2": "handovers_P2_S1_handover_27",
    "handover_3": "handovers_P4_S3_handover_10",
    "handover_4": "sample_new",
    "handover_5": "sample_old",
}
LICENCES = ("LICENSE.handovers_dataset", "LICENSE.STLHandovers")
SEED = 0


def main() -> None:
    """Write all recordings."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kth", type=Path, help="folder of the KTH handovers")
    kth = parser.parse_args().kth
    if kth is not None:
        _handovers(kth)
    for task, demonstrations in STUDY.items():
        for demonstration in demonstrations:
            _write(demonstration.record(SEED), f"study/{task.replace(' ', '_')}", demonstration.name)


def _handovers(kth: Path) -> None:
    for name, folder in HANDOVERS.items():
        parameters = {} if folder == "sample_old" else {"folder": folder}
        mapping = "kth_sample_old" if folder == "sample_old" else "kth_handovers"
        recording = import_recording(
            load_mapping(DATA / "mappings" / f"{mapping}.toml", data_dir=kth, parameters=parameters)
        )
        _write(_labelled(recording), "give", name)
    for licence in LICENCES:
        shutil.copy(kth / licence, DATA / "recordings" / "give" / licence)


def _labelled(recording: Recording) -> Recording:
    """Label from what happens: from the facts, or where the hands were not tracked, from the grip forces."""
    observer = Observer(recording.scene, recording)
    if "P1/right_arm" not in recording.tracked:
        label = propose_label(recording, observer, task="give")
        for check in check_grips(recording, observer, "baton"):
            print(f"  {check.agent} {check.event}: {check.difference_ms:+.0f} ms, supported {check.supported}")
        return recording.with_label(label)
    giver, taker = (recording.signals[f"{agent}_grip"].values for agent in ("P1", "P2"))
    taken, released = ((taker > GRIP_N).argmax(), ((giver < GRIP_N) & (taker > GRIP_N)).argmax())
    end_s = round(float(recording.times_s[[taken, released]].mean()), 3)
    proposed = propose_label(recording, observer, task="give", performing_agent="P1", target_agents="P2", end_s=end_s)
    middle = "ends in the middle of the time in which both grip it, by their forces (the right hands were not tracked)"
    how = f"{proposed.how.partition(';')[0]}; {middle}"
    return recording.with_label(Label("give", "P1", "P2", "baton", proposed.start_s, end_s, how))


def _write(recording: Recording, within: str, name: str) -> None:
    recording = replace(recording, name=name)
    folder = DATA / "recordings" / within
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.mcap"
    write(recording, path)
    print(f"{path.relative_to(DATA)}: {path.stat().st_size / 1000:.0f} kB, {recording.label}")


if __name__ == "__main__":
    main()
