"""Bad input: one message that names file, field, value and way out; exit code 2; nothing written, nothing lost."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.records import Message

from taskgist.facts import STANDARD_TREE, Episode, Observation, predicate_subtree
from taskgist.learning import Knowledge, explain
from taskgist.recording import read, write
from taskgist.settings import DEFAULT, Vision
from taskgist.store import save
from tests.cli.running import refusal
from tests.cli.tampering import Metadata, odometry, tampered
from tests.importing.skeletons import TIMES_S, cup_position, cup_wxyz, keypoints, npz_mapping
from tests.shipped import PATHS

ROOM = '<mujoco><worldbody><body name="cup" pos="1 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
FACTS: dict[str, Any] = {
    "schema": "taskgist.facts/1",
    "task": "show",
    "demonstration": "told",
    "performing_agent": "P1",
    "target_agent": "P2",
    "target_object": "cup",
    "start": {"posture": "Sitting"},
    "end": {"posture": "Sitting"},
}
SCENES = {
    "sound": "",
    "field": 'postur = "sitting"',
    "profile": 'profile = "humen"',
    "seatless": 'posture = "sitting"',
    "posture": 'posture = "lying"',
    "giant": "body = { stature_m = 170 }",
    "nan": "yaw_deg = nan",
    "nowhere": "position_m = [0, inf]",
    "joint": "joints_deg = { head_pam = 10 }",
    "body": "body = 3",
    "size": "body = { statur_m = 1.7 }",
}
LABEL = """[label]
task = "give"
performing_agent = "P1"
target_agent = {}
target_object = "cup"
start_s = 0.1
end_s = {}
"""


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder full of unsound files. No command may change anything in it."""
    folder = tmp_path_factory.mktemp("files")
    (folder / "empty").mkdir()
    _recordings(folder)
    _scenes(folder)
    _knowledge(folder)
    _facts(folder)
    _mappings(folder)
    return folder


def _recordings(folder: Path) -> None:
    good = Path(shutil.copyfile(PATHS["show_a"], folder / "good.mcap"))
    write(read(good).with_label(None), folder / "unlabelled.mcap")
    (folder / "cut.mcap").write_bytes(good.read_bytes()[:40_000])
    (folder / "zero.mcap").write_bytes(b"")
    (folder / "text.mcap").write_text("t,x,y,z\n", encoding="utf-8")
    odometry(folder / "foreign.mcap")

    def label(**fields: object) -> Any:
        return lambda metadata: metadata["taskgist.label"].update(fields)

    def newer(metadata: Metadata) -> None:
        metadata["taskgist.recording"]["format"] = 99

    def backwards(topic: str, number: int, message: Message) -> None:
        if topic == "/taskgist/state" and number == 7:
            message.log_time -= 100_000_000

    def nan(topic: str, number: int, message: Message) -> None:
        if topic == "/taskgist/state" and number == 7:
            state = json.loads(message.data)
            state["objects"]["cup"][2] = float("nan")
            message.data = json.dumps(state).encode()

    tampered(good, folder / "late.mcap", metadata=label(end_s=99.0))
    tampered(good, folder / "several.mcap", metadata=label(target_agent=["P1", "P2"]))
    tampered(good, folder / "nobody.mcap", metadata=label(target_agent=[]))
    tampered(good, folder / "newer.mcap", metadata=newer)
    tampered(good, folder / "backwards.mcap", message=backwards)
    tampered(good, folder / "nan.mcap", message=nan)


def _scenes(folder: Path) -> None:
    (folder / "room.xml").write_text(ROOM, encoding="utf-8")
    (folder / "strange.xml").write_text("<mujoco><oops/></mujoco>", encoding="utf-8")
    for name, line in SCENES.items():
        text = f'[scene]\nmodel = "room.xml"\n[agents.P1]\n{line}\n'
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    (folder / "modelless.toml").write_text('[scene]\nmodel = "rom.xml"\n', encoding="utf-8")
    (folder / "strange.toml").write_text('[scene]\nmodel = "strange.xml"\n', encoding="utf-8")
    (folder / "thing.toml").write_text('[scene]\nmodel = "room.xml"\nobjects = ["cap"]\n', encoding="utf-8")
    (folder / "guessed.toml").write_text('[scene]\nmodel = "room.xml"\nestimated = ["cap"]\n', encoding="utf-8")
    (folder / "list.toml").write_text('[scene]\nmodel = "room.xml"\nobjects = 3\n', encoding="utf-8")
    (folder / "number.toml").write_text('[scene]\nmodel = "room.xml"\n[agents]\nP1 = 3\n', encoding="utf-8")
    (folder / "section.toml").write_text('[scene]\nmodel = "room.xml"\n[agent.P1]\n', encoding="utf-8")
    (folder / "syntax.toml").write_text("[scene\n", encoding="utf-8")
    (folder / "bytes.toml").write_bytes(b"\xff\xfe")


def _knowledge(folder: Path) -> None:
    observed = {"posture": Observation("Sitting")}
    episode = Episode("show", "told", "P1", "P2", "cup", observed, observed, source="told")
    save(Knowledge().add(explain(episode)), folder / "knowledge.db")
    other = replace(DEFAULT, vision=replace(Vision(), change_tolerance=0.5))
    save(Knowledge().add(explain(episode, STANDARD_TREE, other)), folder / "settings.db")
    save(Knowledge().add(explain(episode, STANDARD_TREE.extended(predicate_subtree("on_box")))), folder / "tree.db")
    save(Knowledge().add(explain(episode)), folder / "changed.db")
    with sqlite3.connect(folder / "changed.db") as connection:
        connection.execute("UPDATE taskgist_explanations SET document = replace(document, 'P2', 'P3')")
    connection.close()
    (folder / "cut.db").write_bytes((folder / "knowledge.db").read_bytes()[:5000])


def _facts(folder: Path) -> None:
    variants: dict[str, dict[str, Any]] = {
        "sound": {},
        "attribute": {"start": {"postur": "Sitting"}},
        "value": {"end": {"posture": "Siting"}},
        "score": {"end": {"visibility.score": float("nan")}},
        "many": {"target_agent": ["P2", "P3"]},
        "schema": {"schema": "taskgist.facts/9"},
    }
    for name, changes in variants.items():
        (folder / f"{name}.json").write_text(json.dumps(FACTS | changes), encoding="utf-8")
    (folder / "syntax.json").write_text("{", encoding="utf-8")
    (folder / "bytes.json").write_bytes(b"\xff\xfe")


def _mappings(folder: Path) -> None:
    sound = npz_mapping(folder)
    tables: dict[str, Any] = {"t": TIMES_S, "body": keypoints(), "cup": np.hstack([cup_position(), cup_wxyz()])}
    np.savez(folder / "millimetres.npz", **(tables | {"body": 1000 * keypoints()}))
    np.savez(folder / "timeless.npz", **(tables | {"t": np.where(np.arange(len(TIMES_S)) == 7, np.nan, TIMES_S)}))
    np.savez(folder / "reversed.npz", **(tables | {"t": TIMES_S[::-1]}))
    np.savez(folder / "unseen.npz", **(tables | {"body": np.full_like(keypoints(), np.nan)}))
    mappings = {
        "map_sound": sound,
        "map_key": sound.replace('units = "m"', 'units = "m"\nunit = "m"', 1),
        "map_landmark": sound.replace('pelvis = "PELVIS"', 'pelvic = "PELVIS"'),
        "map_several": sound + LABEL.format('["P1", "P2"]', 0.9),
        "map_late": sound + LABEL.format('"P2"', 99),
        "map_stranger": sound + LABEL.format('"P3"', 0.9),
        **{
            f"map_{t}": sound.replace("data.npz", f"{t}.npz") for t in ("millimetres", "timeless", "reversed", "unseen")
        },
        "map_missing": sound.replace("data.npz", "none.npz"),
    }
    for name, text in mappings.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")


NO_FILE = "No such file or directory"
NO_FOLDER = "there is no folder 'nowhere'; name a file in a folder that you may write to"
AGENTS = "did you mean 'P2'? (known: P1, P2)"

CASES: dict[str, list[str]] = {
    # recordings
    "check none.mcap": ["none.mcap: cannot be read: ", NO_FILE, "check the path"],
    "check good.mcap none.mcap": ["none.mcap: cannot be read: ", NO_FILE],
    "check empty": ["empty: no recordings (*.mcap) in this folder; name a recording, or a folder that holds some"],
    "check zero.mcap": ["zero.mcap: the file is empty; copy or import"],
    "check cut.mcap": ["cut.mcap: the file is cut off or damaged", "; copy it again from where it came from"],
    "check text.mcap": ["text.mcap: not an MCAP file (got b't,x,y,z", "taskgist import"],
    "check foreign.mcap": [
        "foreign.mcap: an MCAP file, but not a recording of taskgist (got 'topics: /odometry')",
        "; ",
    ],
    "check newer.mcap": ["newer.mcap: format: ", "newer format (got 99)", "install a newer one"],
    "check backwards.mcap": ["backwards.mcap: ", "times run backwards at frame 7 (got ("],
    "check nan.mcap": ["nan.mcap: /taskgist/state, frame 7: objects.", ": is no finite number (got nan)"],
    "facts late.mcap": [
        "late.mcap: end_s: the label reaches outside of the recording (got 99.0); give a time between 0"
    ],
    "facts several.mcap": ["several.mcap: target_agent: performing and target agent are the same (got 'P1'); name"],
    "facts nobody.mcap": ["nobody.mcap: target_agent: no target agent (got []); name at least one"],
    "facts good.mcap --agent P3": [f"good.mcap: no agent 'P3'; {AGENTS}"],
    "facts good.mcap --object Cap": ["good.mcap: no object 'Cap'; did you mean 'cup'? (known: book, bottle, cup, "],
    "facts good.mcap --at 99": [
        "good.mcap: ",
        "--at: ",
        "outside of the recording (got 99.0); give a time between 0 and",
    ],
    "facts good.mcap --at nan": ["good.mcap: ", "--at: ", "(got nan); give a time between"],
    "facts unlabelled.mcap": ["unlabelled.mcap: the recording has no label; name --agent and --object"],
    "facts empty": ["empty: cannot be read: it is a folder"],
    # labels
    "label good.mcap --target P1 --target P2": ["good.mcap: --target: performing and target agent are the same (got"],
    "label good.mcap --target P2 --target P2": ["good.mcap: --target: one target agent stands twice (got 'P2'); name"],
    "label good.mcap --target P2 --target P4": [f"good.mcap: no agent 'P4'; {AGENTS}"],
    "label good.mcap --object cup --object pen": ["good.mcap: no object 'pen' (known: book, bottle, cup, "],
    "label good.mcap --start 1 --end 99": [
        "good.mcap: --end: ",
        "outside",
        "(got 99.0); give a time between 0 and 7.",
    ],
    "label good.mcap --start 7": ["good.mcap: --end: the label ends before it starts", "after start_s = 7"],
    "label good.mcap --start nan": ["good.mcap: --start: must be a time (got nan); give seconds"],
    "label good.mcap --target P3": [f"good.mcap: no agent 'P3'; {AGENTS}"],
    "label good.mcap --target P1": ["good.mcap: --target: performing and target agent are the same (got 'P1'); name"],
    "label good.mcap --task ''": ["good.mcap: --task: is empty (got ''); give a short text of one line"],
    "label unlabelled.mcap --task show": ["unlabelled.mcap: label: missing: --performer, --target, --object, --start,"],
    "label unlabelled.mcap --propose": ["unlabelled.mcap: --task: the facts do not tell", "name it: --task show"],
    "label cut.mcap --task show": ["cut.mcap: the file is cut off or damaged"],
    # pictures
    "see good.mcap --agent P3": [f"good.mcap: no agent 'P3'; {AGENTS}"],
    "see good.mcap --agent P2 --object cub": ["good.mcap: no object 'cub'; did you mean 'cup'?"],
    "see good.mcap --agent P2 --at -1": ["good.mcap: ", "--at: ", "(got -1.0); give a time between"],
    "see good.mcap --agent P2 -o nowhere/x.png": ["nowhere/x.png: --out: cannot be written: ", NO_FOLDER],
    "see good.mcap --agent P2 -o empty": ["empty: --out: cannot be written: it is a folder; name a file"],
    # scenes
    "see none.toml --agent P1": ["none.toml: cannot be read: ", NO_FILE, "check the path"],
    "see syntax.toml --agent P1": ["syntax.toml: not valid TOML: ", "line 1"],
    "see sound.toml --agent P1 --at 1": ["sound.toml: --at: a scene has no time (got 1.0); leave --at out"],
    "see field.toml --agent P1": ["field.toml: [agents.P1]: no field 'postur'; did you mean 'posture'? (known: "],
    "see profile.toml --agent P1": [
        "profile.toml: agents.P1: no profile 'humen'; did you mean 'human'? (known: hrp2, human"
    ],
    "see posture.toml --agent P1": ["posture.toml: agents.P1: no posture 'lying' (known: sitting, standing)"],
    "see seatless.toml --agent P1": [
        "seatless.toml: agents.P1.position_m: nothing to sit on there (got ",
        "over a seat",
    ],
    "see giant.toml --agent P1": ["giant.toml: agents.P1.body.stature_m: ", "(got 170.0)", "metres: check the unit"],
    "see nan.toml --agent P1": ["nan.toml: agents.P1.yaw_deg: must be a finite number (got nan)"],
    "see nowhere.toml --agent P1": ["nowhere.toml: agents.P1.position_m: must be two finite numbers (got [0, inf])"],
    "see joint.toml --agent P1": ["joint.toml: agents.P1.joints_deg: no joint 'head_pam'; did you mean 'head_pan'?"],
    "see modelless.toml --agent P1": ["modelless.toml: scene.model: no such file (got 'rom.xml'); paths are relative"],
    "see strange.toml --agent P1": ["strange.xml: MuJoCo cannot read this model: ", "'oops'"],
    "see thing.toml --agent P1": ["thing.toml: no object (a body of the model) 'cap'; did you mean 'cup'?"],
    "see guessed.toml --agent P1": ["guessed.toml: scene.estimated: no body 'cap'; did you mean 'cup'? (known: "],
    "see list.toml --agent P1": ["list.toml: scene.objects: must be a list of texts (got 3)"],
    "see number.toml --agent P1": ["number.toml: agents.P1: must be a table (got 3); write [agents.P1]"],
    "see section.toml --agent P1": [
        "section.toml: ",
        "no field 'agent'; did you mean 'agents'? (known: agents, furniture, objects, scene)",
    ],
    "see bytes.toml --agent P1": ["bytes.toml: not valid TOML: ", "; save it as TOML in UTF-8"],
    "see body.toml --agent P1": ["body.toml: agents.P1.body: must be a table (got 3); write [agents.P1.body]"],
    "see size.toml --agent P1": ["size.toml: agents.P1.body.statur_m: no such body size", "stature_m"],
    # learning
    "learn": ["no demonstrations to learn from; name at least one labelled recording or facts file"],
    "learn empty": ["empty: no recordings (*.mcap) in this folder; name a recording"],
    "learn unlabelled.mcap": ["unlabelled.mcap: ", "the recording has no label; set one: taskgist label RECORDING"],
    "learn sound.json none.json": ["none.json: cannot be read: ", NO_FILE],
    "learn attribute.json": ["attribute.json: start.postur: no such attribute; did you mean 'posture'? (allowed: "],
    "learn value.json": ["value.json: end.posture: no such value (got 'Siting'); did you mean 'Sitting'? (allowed: "],
    "learn score.json": ["score.json: end.visibility.score: not a visibility score (got nan); give "],
    "learn many.json": [
        "many.json: target_agent: not one name (got ['P2', 'P3']); several at once",
        "one file for each",
    ],
    "learn schema.json": [
        "schema.json: schema: another format (got 'taskgist.facts/9'); this release reads 'taskgist."
    ],
    "learn syntax.json": ["syntax.json: not JSON: ", "write a taskgist.facts/1 file"],
    "learn bytes.json": ["bytes.json: not JSON: ", "write a taskgist.facts/1 file"],
    "learn sound.json -k settings.db": [
        "settings.db: made with settings ",
        "is in use; use the settings",
        "learn anew",
    ],
    "learn sound.json -k tree.db": ["tree.db: made with settings ", "is in use; use the settings", "learn anew"],
    "learn sound.json -k changed.db": ["changed.db: row '", "digest: damaged explanation"],
    "learn sound.json -k cut.db": [
        "cut.db: is damaged knowledge: ",
        "; restore it from a copy",
    ],
    "learn sound.json -k room.xml": ["room.xml: cannot be used as knowledge: file is not a database; give a knowledge"],
    "learn good.mcap -k nowhere/k.db": ["nowhere/k.db: cannot be written: ", NO_FOLDER],
    "learn good.mcap -k empty": ["empty: cannot be knowledge: it is a folder; name a file"],
    "explain show -k none.db": ["none.db: no such knowledge file; learn something first"],
    "explain show -k settings.db": ["settings.db: made with settings ", "learn anew"],
    "explain show -k cut.db": ["cut.db: is damaged knowledge: ", "; restore it from a copy"],
    "explain shw": ["knowledge.db: no task 'shw'; did you mean 'show'? (known: show)"],
    "explain show --why see.clas": ["no node 'see.clas'; did you mean 'see.class'? (known: "],
    "explain show --rule bays": ["no rule 'bays'; did you mean 'bayes'? (known: bayes, paper)"],
    "explain shw --rule bayes": ["knowledge.db: no task 'shw'; did you mean 'show'? (known: show)"],
    "explain show --rule bayes --why see.class": ["--why: is about the paper's rule", "leave out --rule"],
    "explain show --band wid": ["no band 'wid'; did you mean 'wide'? (known: narrow, sharp, wide)"],
    # importing
    "import none.toml -o out.mcap": ["none.toml: cannot be read", NO_FILE],
    "import map_sound.toml -o nowhere/out.mcap": ["nowhere/out.mcap: --out: cannot be written: ", NO_FOLDER],
    "import map_sound.toml -o empty": ["empty: --out: cannot be written: it is a folder; name a file"],
    "import map_sound.toml -o data.npz --replace": ["data.npz: --out: is read by the same command; name another file"],
    "import map_sound.toml -o map_sound.toml --replace": ["map_sound.toml: --out: is read by the same command"],
    "import map_sound.toml -o out.mcap --set take": ["--set: not a parameter (got 'take'); write NAME=VALUE"],
    "import map_sound.toml -o out.mcap --set take=1": ["map_sound.toml: no parameter 'take' (known"],
    "import map_missing.toml -o new.mcap": ["map_missing.toml: ", "none.npz: ", NO_FILE],
    "import map_key.toml -o new.mcap": ["map_key.toml: [sources.body]: no field 'unit'", "did you mean 'units'"],
    "import map_landmark.toml -o new.mcap": [
        "map_landmark.toml: people.P1.points",
        "'pelvic'",
        "did you mean 'pelvis'",
    ],
    "import map_millimetres.toml -o new.mcap": ["map_millimetres.toml: people.P1", "m across", "units"],
    "import map_timeless.toml -o new.mcap": ["map_timeless.toml: ", "timeless.npz", "frame 7: time: t: ", "nan"],
    "import map_reversed.toml -o new.mcap": ["map_reversed.toml: ", "reversed.npz", "times run backwards", "; "],
    "import map_unseen.toml -o new.mcap": ["map_unseen.toml: people.P1", "never"],
    "import map_several.toml -o new.mcap": [
        "map_several.toml: label: target_agent: performing and target agent are the same (got 'P1'); name",
    ],
    "import map_late.toml -o new.mcap": [
        "map_late.toml: label: end_s: the label reaches outside",
        "(got 99",
        "give a time",
    ],
    "import map_stranger.toml -o new.mcap": [f"map_stranger.toml: label: no agent 'P3'; {AGENTS}"],
    # demonstrating
    "demo -o room.xml": ["room.xml: --out: cannot be made: File exists; name a folder"],
    "demo -o room.xml/demo": ["room.xml/demo: --out: cannot be made: Not a directory; name a folder"],
}


@pytest.mark.parametrize("line", CASES)
def test_refusals(line: str, sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(sound)
    message = refusal(line, sound)
    for part in CASES[line]:
        assert part in message


def test_refusals_print_no_half_a_document(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(sound)
    for line in (
        "check cut.mcap --json",
        "check good.mcap none.mcap --json",
        "learn sound.json none.json --json",
        "see cut.mcap --agent P1 --json",
    ):
        assert refusal(line, sound)


def test_folders_that_may_not_be_written_to(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(sound)
    monkeypatch.setattr(
        os, "access", lambda _path, mode: mode != os.W_OK
    )  # whoever runs the tests may be allowed everything
    assert "new.db: cannot be written: the folder '.' is read-only; name a file" in refusal(
        "learn good.mcap -k new.db", sound
    )
    for line in (
        "see good.mcap --agent P2 -o new.png",
        "import map_sound.toml -o new.mcap",
    ):
        assert "cannot be written: the folder '.' is read-only; name a file" in refusal(line, sound)
