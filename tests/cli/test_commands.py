"""Each command does what it says, on the shipped recordings: as text, and as one JSON document."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.learning import Knowledge
from taskgist.recording import read, write
from taskgist.store import load, save
from tests.cli.running import contents, refusal, run, run_json
from tests.importing.skeletons import mapping_file, npz_mapping
from tests.learning.learning_samples import STUDY, explained
from tests.pipeline.small import small
from tests.scenes import TABLE, agent, cylinder, scene
from tests.shipped import PATHS, excerpt, explanation, label

SHOW = PATHS["show_a"]
PNG = b"\x89PNG\r\n"

pytestmark = pytest.mark.usefixtures("coarse_pictures")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def handovers(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The essential seconds of two handovers."""
    folder = tmp_path_factory.mktemp("handovers")
    for name in ("handover_1", "handover_2"):
        write(excerpt(name, 1.2, 4.2), folder / f"{name}.mcap")
    return folder / "handover_1.mcap", folder / "handover_2.mcap"


@pytest.fixture
def own(folder: Path, handovers: tuple[Path, Path]) -> Path:
    """A copy of a recording, to be changed."""
    return Path(shutil.copyfile(handovers[0], folder / "own.mcap"))


def test_demo(folder: Path, monkeypatch: pytest.MonkeyPatch, handovers: tuple[Path, Path]) -> None:
    """With one recording; the whole is held against the README."""
    monkeypatch.setattr("taskgist.cli.demo.TASKS", {"give": "a real handover"})
    monkeypatch.setattr("taskgist.cli.demo.shipped_recordings", lambda _: [handovers[0]])
    document = run_json("demo -o out/new")
    assert set(contents(folder)) == {"out", "out/new", "out/new/give.png", "out/new/knowledge.db"}
    assert document["knowledge"] == "out/new/knowledge.db"
    assert document["tasks"]["give"]["picture"] == "out/new/give.png"
    assert {each["name"] for each in document["tasks"]["give"]["demonstrations"]} == {"handover_1"}
    assert (folder / "out/new/give.png").read_bytes().startswith(PNG)
    assert document["tasks"]["give"] == {
        **run_json("explain give -k out/new/knowledge.db --rule paper"),
        "picture": "out/new/give.png",
    }


def test_import(folder: Path) -> None:
    mapping_file(folder, npz_mapping(folder))
    text = run("import mapping.toml -o out.mcap")
    assert text.startswith("wrote out.mcap: 31 frames, 1.00 s\n")
    assert "fit of P1" in text
    made = read("out.mcap")
    document = run_json("import mapping.toml -o again.mcap")
    assert document["recording"] == "again.mcap"
    assert (document["frames"], document["agents"], document["objects"]) == (31, ["P1", "P2"], ["cup"])
    assert set(document["fit"]) == {"P1", "P2"}
    assert read("again.mcap").digest == made.digest
    assert set(contents(folder)) == {"mapping.toml", "data.npz", "out.mcap", "again.mcap"}


def test_import_with_parameters(folder: Path) -> None:
    (folder / "data").mkdir()
    mapping_file(folder, npz_mapping(folder / "data").replace("data.npz", "{take}.npz") + '[parameters]\ntake = ""\n')
    document = run_json("import mapping.toml --data data --set take=data -o out.mcap")
    assert read("out.mcap").name == "mapping"
    assert document["seconds"] == pytest.approx(1.0)


def test_label_shows(own: Path) -> None:
    before = own.read_bytes()
    text = run("label own.mcap")
    assert "target agent      P2\n" in text
    document = run_json("label own.mcap")
    assert (document["task"], document["performing_agent"], document["target_object"]) == ("give", "P1", "baton")
    assert own.read_bytes() == before


def test_label_sets_and_changes_nothing_else(own: Path) -> None:
    original = read(own)
    assert original.label is not None
    document = run_json("label own.mcap --task pass --performer P2 --target P1 --object baton --start 1.5 --end 2.5")
    assert [document[key] for key in ("task", "performing_agent", "start_s", "end_s")] == ["pass", "P2", 1.5, 2.5]
    changed = read(own)
    assert changed.label is not None
    assert changed.label.as_dict() == document
    assert changed.digest == original.digest
    assert changed.provenance == original.provenance
    assert set(changed.signals) == set(original.signals)
    run("label own.mcap --start 1.4")
    run("label own.mcap --start 1.3")
    again = run_json("label own.mcap")
    assert again == {**document, "start_s": 1.3, "how": again["how"]}
    assert again["how"].startswith(original.label.how.partition("; by hand")[0]), (
        "how the end was found is not forgotten"
    )
    assert again["how"].count("by hand: ") == 1
    assert again["how"].count("start_s") == 1


@pytest.fixture
def several(folder: Path) -> Path:
    """A recording that is about two things: the cup that is shown, and the bottle that stays where it is."""
    path = folder / "several.mcap"
    write(excerpt("show_a", 0.0, np.inf, every=2), path)
    document = run_json("label several.mcap --object cup --object bottle")
    assert (document["target_agent"], document["target_object"]) == ("P2", ["cup", "bottle"])
    return path


def test_label_takes_several_targets(several: Path) -> None:
    text = run("label several.mcap")
    assert "target agent      P2\n" in text
    assert "target objects    cup, bottle\n" in text
    before = label("show_a")
    assert read(several).label == replace(
        before, target_objects=("cup", "bottle"), how=f"{before.how}; by hand: target_object"
    )


@pytest.mark.usefixtures("several")
def test_label_proposes_for_several_things() -> None:
    alone, both = (
        run_json(f"label several.mcap --propose --task show {options} --dry-run")
        for options in ("--object cup", "--object cup --object bottle")
    )
    assert both["target_object"] == ["cup", "bottle"]
    assert both["start_s"] <= alone["start_s"] < alone["end_s"] <= both["end_s"]


@pytest.mark.usefixtures("several")
def test_facts_of_several_things() -> None:
    document = run_json("facts several.mcap --every 5")
    assert (document["agents"], document["objects"]) == (["P2"], ["cup", "bottle"])
    assert document["each"] == [run_json(f"facts several.mcap --every 5 --object {name}") for name in ("cup", "bottle")]
    values = [{name: node["value"] for name, node in each["effect"].items()} for each in document["each"]]
    for name, node in document["effect"].items():
        assert node["value"] == (values[0][name] if values[0][name] == values[1][name] else None)
    text = run("facts several.mcap --every 5")
    assert "effect of 'show' on cup for P2, between" in text
    assert "effect of 'show' on each of bottle and cup for P2, between" in text
    assert (
        "= unknown (differs: Maintaining(On_Support) for bottle; Gaining(In_Hand) & Losing(On_Support) for cup)\n"
        in text
    )
    at = run_json("facts several.mcap --at 3")
    assert [each["object"] for each in at["each"]] == ["cup", "bottle"]
    assert at["effect"] is None
    assert len(run_json("facts several.mcap --relations")["each"]) == 2


def test_check_tells_of_each_target(several: Path) -> None:
    (document,) = run_json(f"check {several}")
    assert document["fit"]


@pytest.mark.usefixtures("several")
def test_what_is_learned_from_several_things_is_said_of_each_and_asked_where_they_differ() -> None:
    run("learn several.mcap -k k.db")
    text = run("explain show -k k.db --rule paper")
    assert "Task(show, each of the target objects) ←" in text
    assert "question What does “show” mean" in text
    assert "for bottle in show_a" in text
    document = run_json("explain show -k k.db --rule paper")
    assert document["clause"]["each_of"] == ["target objects"]
    choices = [choice for question in document["questions"] for choice in question["choices"]]
    assert {target["target"] for choice in choices for target in choice["targets"]} == {"cup", "bottle"}


def test_label_tries_without_writing(own: Path) -> None:
    before = own.read_bytes()
    assert run_json("label own.mcap --end 3 --dry-run")["end_s"] == 3.0
    assert own.read_bytes() == before


def test_label_proposes(own: Path) -> None:
    write(read(own).with_label(None), own)
    assert "no label; set one with --task" in run("label own.mcap", exit_code=1)
    assert run_json("label own.mcap", exit_code=1) is None
    document = run_json("label own.mcap --propose --end 3.5")
    assert (document["task"], document["performing_agent"], document["target_agent"]) == ("give", "P1", "P2")
    assert document["end_s"] == 3.5
    assert document["how"].startswith("proposed: ")
    assert document["how"].endswith("by hand: end_s")
    kept = read(own).label
    assert kept is not None
    assert kept.as_dict() == document


def test_who_is_alone_is_labelled_without_a_target(folder: Path) -> None:
    """What changes for the performer itself is then told and learned."""
    world = scene(TABLE, cylinder("cup", 0.1, 0.0, 0.771), agents=agent("P1", -0.8, 0.0))
    write(small(world, label=None), folder / "alone.mcap")
    document = run_json("label alone.mcap --task tidy --performer P1 --object cup --start 0.2 --end 0.8")
    assert document["target_agent"] is None
    assert "target agent      none: it is P1's own\n" in run("label alone.mcap")
    assert run_json("label alone.mcap --end 0.7")["target_agent"] is None
    assert run_json("facts alone.mcap --every 1")["agent"] == "P1"
    run("learn alone.mcap -k k.db")
    assert "“tidy” means" in run("explain tidy -k k.db")
    assert run_json("check alone.mcap")[0]["fit"]


def test_a_label_that_is_not_sure_is_not_proposed(own: Path, folder: Path) -> None:
    """The baton is known nowhere for most of the time in which it is given."""
    whole = read(own)
    lost = (whole.times_s > 2.0) & (whole.times_s < 3.3)
    write(replace(whole, label=None, tracked={**whole.tracked, "baton": ~lost}), own)
    message = refusal("label own.mcap --propose --task give", folder)
    assert (
        "own.mcap: label: what happens is not clear enough to propose a label: it is unknown who has baton" in message
    )


def test_check(own: Path, folder: Path, handovers: tuple[Path, Path]) -> None:
    write(read(own).with_label(None), own)
    text = run(f"check own.mcap {handovers[0]}", exit_code=1)
    assert f"{handovers[0]}: fit to learn from\n" in text
    assert "own.mcap: not fit to learn from\n  unfit    label: there is none → set one: " in text
    (folder / "more").mkdir()
    own.rename("more/own.mcap")
    (document,) = run_json("check more", exit_code=1)
    assert (document["recording"], document["fit"]) == ("more/own.mcap", False)
    assert document["findings"][0]["severity"] == "unfit"


def test_facts_over_time(handovers: tuple[Path, Path]) -> None:
    document = run_json(f"facts {handovers[0]} --every 2")
    assert (document["agent"], document["object"], document["every_s"]) == ("P2", "baton", 2.0)
    assert set(document["timeline"]) == set(STANDARD_TREE.attributes)
    assert {name: node["value"] for name, node in document["effect"].items()} == {
        name: node.to_json()["value"] for name, node in explanation("handover_1").nodes.items()
    }
    text = run(f"facts {handovers[0]}")
    assert text.startswith("baton for P2, sampled every 0.5 s\n")
    assert "  placement\n" in text
    assert "Object_Relative_Status = Gaining(In_Hand) & Losing(On_Support)" in text


def test_facts_of_another_agent_and_object() -> None:
    document = run_json(f"facts {SHOW} --agent P1 --object bottle --every 5")
    assert (document["agent"], document["object"]) == ("P1", "bottle")
    assert document["effect"]["placement.class"]["value"] == "Maintaining(On_Support)"


def test_facts_at_a_time(handovers: tuple[Path, Path]) -> None:
    document = run_json(f"facts {handovers[0]} --agent P2 --object baton --at 3.5")
    assert document["time_s"] == pytest.approx(3.5, abs=1 / 60)
    assert document["attributes"]["hands"]["value"]["right"] == "Holding_Object"
    assert document["attributes"]["reach.effort"]["value"] == "No_Effort_Required"
    text = run(f"facts {handovers[0]} --at 1.7")
    assert "baton for P2 at 1.70 s" in text
    assert "beyond the" in text


def test_relations_over_time(handovers: tuple[Path, Path]) -> None:
    document = run_json(f"facts {handovers[0]} --relations")
    assert (document["agent"], document["object"], document["distance_change"]) == ("P2", "baton", "nearer")
    carried = [each["value"] for each in document["relations"]["carried_by"]]
    assert carried[-3:] == ["P1", "P1, P2", "P2"]
    text = run(f"facts {handovers[0]} --relations")
    assert text.startswith("baton and P2, exact to the frame\n")
    assert "  touching\n" in text
    assert "s  yes\n" in text
    assert "between the label's start and end the distance: nearer" in text


def test_relations_at_a_time_tell_what_they_stand_on() -> None:
    document = run_json(f"facts {PATHS['hide_a']} --relations --at 9.5")
    seen = document["relations"]["sight"]
    assert seen["value"] == "blocked"
    assert list(seen["evidence"]["blockers"]) == ["white_box"]
    assert document["relations"]["approaching"]["value"] is False
    text = run(f"facts {PATHS['hide_a']} --relations --at 9.5")
    assert text.startswith("cup and P2 at 9.5")
    assert "blocked   (0% in sight, white_box hides 100%)" in text


def test_learn_and_explain(folder: Path, handovers: tuple[Path, Path]) -> None:
    learned = run_json(f"learn {handovers[0]} {handovers[1]} -k k.db")
    assert set(learned["tasks"]) == {"give"}
    before = load("k.db")
    text = run(f"learn {handovers[0]} -k k.db")
    assert "kept in k.db" in text
    assert load("k.db") == before, "what is known already changes nothing"
    assert run_json("explain give -k k.db --rule paper") == learned["tasks"]["give"]
    assert run("explain -k k.db") == "give\n"
    assert run_json("explain -k k.db") == ["give"]
    whole = run("explain give -k k.db --rule paper")
    assert "Task(give) ←   by the paper's rule, from 2 demonstrations" in whole
    assert all(f"{node.title} = " in whole for node in STANDARD_TREE.nodes)
    assert set(contents(folder)) == {"k.db"}


def test_explain_by_whole_clauses_compares_with_all_that_is_known(folder: Path) -> None:
    study = [explained(task, i, told) for task in STUDY for i, told in enumerate(STUDY[task])]
    wrong = replace(explained("hide", 9, STUDY["hide"][0]), task="give", demonstration="strange")
    save(Knowledge().add(*study, wrong), folder / "k.db")
    document = run_json("explain give -k k.db --rule bayes")
    assert document["clause"]["literals"][0]["text"] == "(Nature_Hand_Status = Manip_Desired)"
    assert (document["clause"]["k"], document["clause"]["n"]) == (3, 4)
    assert document["compared"]["tasks"]["hide"] == len(STUDY["hide"])
    assert document["compared"]["neutral"]["lift"] > 0
    assert [each["name"] for each in document["odd"]] == ["strange"]
    text = run("explain give -k k.db")
    assert text == run("explain give -k k.db --rule bayes"), "it speaks where none is named"
    assert text.startswith("“give” means for the target agent: it has the object in hand at the end.\n")
    assert "Task(give) ←   by whole clauses, compared with 5 other tasks and " in text
    assert "(Nature_Hand_Status = Manip_Desired)   in 3 of 4; by chance in 1 of " in text
    assert "strange looks like 'hide'" in text
    assert "usual circumstances" in run("explain hide -k k.db --rule bayes")


def test_the_performing_agents_own_tree_stands_beside_the_targets(folder: Path, handovers: tuple[Path, Path]) -> None:
    """P1, who gives, ends without the baton, reached as before; P2 ends with it (7.2)."""
    told = run_json(f"facts {handovers[1]} --of performer --every 3")
    assert told["agent"] == "P1"
    assert told == run_json(f"facts {handovers[1]} --agent P1 --every 3")
    assert told["effect"]["hands.class"]["value"] == "Manip_Avoided"
    assert told["effect"]["reach.class"]["value"] == "Remains_Same"
    run(f"learn {handovers[0]} -k k.db")
    message = refusal("explain give -k k.db --of performer", folder)
    assert "k.db: task give: --of: known of target agents alone" in message
    learned = run_json(f"learn {handovers[0]} {handovers[1]} -k k.db --of performer")["tasks"]["give"]
    assert learned["nodes"]["reach.nature"]["value"] == "Supportive"
    assert run_json("explain give -k k.db --of performer") == learned, "with nothing to compare with, the paper's rule"
    assert [run_json(f"explain give -k k.db --of {of}")["of"] for of in ("target", "performer")] == [
        "target",
        "performer",
    ]
    assert "“give” means for the performing agent: " in run("explain give -k k.db --of performer")
    assert "by the paper's rule, from 1 demonstration\n" in run("explain give -k k.db --rule paper")
    assert run("explain -k k.db") == "give   (--of performer, too)\n"
    assert run_json("explain give -k k.db --of performer --why reach.nature")["of"] == "performer"
    assert "no tree of 'giver'" in refusal(f"learn {handovers[0]} --of giver", folder)
    assert "--agent says already whose" in refusal(f"facts {handovers[0]} --agent P2 --of performer", folder)


def test_learn_from_facts_and_recordings_at_once(folder: Path, handovers: tuple[Path, Path]) -> None:
    for path in handovers:
        shutil.copyfile(path, folder / path.name)
    document = {
        "schema": "taskgist.facts/1",
        "task": "give",
        "demonstration": "told",
        "performing_agent": "P1",
        "target_agent": "P2",
        "target_object": "cup",
        "start": {"posture": "Sitting"},
        "end": {"posture": "Sitting"},
    }
    (folder / "told.json").write_text(json.dumps(document), encoding="utf-8")
    assert "its facts are those of the target agent, P2" in refusal("learn . told.json --of performer", folder)
    learned = run_json("learn . told.json")
    (nodes,) = [each["nodes"] for each in learned["tasks"].values()]
    assert nodes["posture.value.1"]["counts"] == {"Standing": 2, "Sitting": 1}
    assert nodes["placement.status.1"]["N"] == 2, "unknown is not counted"
    assert (folder / "knowledge.db").is_file()


def test_explain_why_and_with_another_band(folder: Path) -> None:
    save(Knowledge().add(explanation("handover_1"), explanation("handover_2")), folder / "k.db")
    text = run("explain give -k k.db --why visibility.class")
    assert text.startswith("By the paper's rule: Object_Relative_Visibility_Score counts: ")
    document = run_json("explain give -k k.db --why visibility.class")
    assert f"By the paper's rule: {document['why']}" == text.strip()
    assert document["rule"] == "paper"
    narrow, wide = (run_json(f"explain give -k k.db --band {band}")["nodes"] for band in ("narrow", "wide"))
    assert narrow["visibility.class"]["d1"]["exact"] == "21/40"
    assert wide["visibility.class"]["d1"]["exact"] == "3/10"


def test_see_a_recording(folder: Path) -> None:
    shutil.copyfile(SHOW, folder / "show.mcap")
    text = run("see show.mcap --agent P2 --object cup --at 6.4")
    assert text.startswith("saved show_P2_sees.png\n")
    assert "visibility score" in text
    assert (folder / "show_P2_sees.png").read_bytes().startswith(PNG)
    document = run_json("see show.mcap --agent P2 --at 6.4 -o out.png")
    assert document["picture"] == "out.png"
    assert document["time_s"] == pytest.approx(6.4, abs=0.02)
    assert set(document["objects"]) == {"cup", "book", "bottle", "white_box"}
    assert document["objects"]["cup"]["visibility"] > 0
    assert set(contents(folder)) == {"show.mcap", "show_P2_sees.png", "out.png"}


def test_see_a_scene(folder: Path) -> None:
    room = (
        '<mujoco><worldbody><body name="cup" pos="1 0 1.5"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    (folder / "room.xml").write_text(room, encoding="utf-8")
    (folder / "room.toml").write_text('[scene]\nmodel = "room.xml"\n[agents.P1]\n[agents.P2]\nposition_m = [0, 9]\n')
    assert "cup                  visibility score" in run("see room.toml --agent P1")
    assert "not visible" in run("see room.toml --agent P2")
    assert set(contents(folder)) == {"room.xml", "room.toml", "room_P1_sees.png", "room_P2_sees.png"}


def test_names_in_brackets_and_colons_are_printed_as_they_are(own: Path) -> None:
    own.rename("take[bold] :cup:.mcap")
    assert run("check 'take[bold] :cup:.mcap'").startswith("take[bold] :cup:.mcap: fit")
    assert run("label 'take[bold] :cup:.mcap' --task 'a [b] :cup:'").startswith("task              a [b] :cup:\n")
