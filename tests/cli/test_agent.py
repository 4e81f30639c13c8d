"""``taskgist agent check``: what a profile has, what it lacks, and what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from taskgist.world import builtin_profiles
from tests.bodies import needs
from tests.cli.running import refusal, run, run_json

TIAGO = Path(__file__).parents[2] / "examples" / "profiles" / "tiago.toml"
ROBOT = """<robot name="r"><link name="base"><collision><geometry><box size="0.4 0.4 1"/></geometry></collision></link>
<link name="head"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="neck" type="revolute"><parent link="base"/><child link="head"/><origin xyz="0 0 0.6"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
PROFILE = """name = "pillar"
model = "pillar.urdf"
[eye]
frame = "head"
exclude = "head"
fov_deg = [60, 40]
image_px = [64, 48]
[head]
pan = { joint = "neck" }
"""


@pytest.fixture
def pillar(tmp_path: Path) -> Path:
    (tmp_path / "pillar.urdf").write_text(ROBOT)
    (tmp_path / "pillar.toml").write_text(PROFILE)
    return tmp_path / "pillar.toml"


@pytest.mark.parametrize("name", [pytest.param(n, marks=needs(n)) for n in builtin_profiles()])
def test_built_in_bodies_are_fit(name: str) -> None:
    text = run(f"agent check {name}")
    assert text.startswith(f"{name}: fit to use\n")
    for what in ("eye", "head", "torso", "postures", "right arm", "hand", "parts"):
        assert f"\n  {what}" in text, what


@needs("tiago")
def test_a_sixth_body_with_one_toml_and_no_code(tmp_path: Path) -> None:
    picture = tmp_path / "tiago.png"
    found = run_json(f"agent check {TIAGO} -o {picture}")
    assert found["fit"]
    assert found["name"] == "tiago"
    assert found["eye"]["looks_along"] == pytest.approx([1, 0, 0], abs=0.01)
    assert found["eye"]["hidden_by_itself"] == {}
    (arm,) = found["arms"]
    assert (arm["side"], arm["length"]) == ("right", "derived")
    assert 0.8 < arm["length_m"] < 1.0
    assert set(found["joints"]) == {"head.pan", "head.tilt"}
    with Image.open(picture) as image:
        assert image.width > 600


def test_the_picture_shows_the_body_and_its_reach(tmp_path: Path) -> None:
    picture = tmp_path / "human.png"
    assert run(f"agent check human -o {picture}").endswith(f"saved {picture}\n")
    first = picture.read_bytes()
    run(f"agent check human -o {picture} --replace")
    assert picture.read_bytes() == first, "the same body gives the same picture"
    with Image.open(picture) as image:
        colours = {colour for _, colour in image.convert("RGB").getcolors(1 << 24)}  # type: ignore[union-attr]
    for drawn in ((0x1F, 0x6F, 0xB4), (0xD2, 0x60, 0x1A), (0x3A, 0x9A, 0x4F)):
        assert drawn in colours


def test_what_a_body_lacks_is_said_with_what_follows(pillar: Path) -> None:
    found = run_json(f"agent check {pillar}")
    assert found["fit"]
    said = "\n".join(found["lacks"])
    for lack in (
        "no arms: it reaches",
        "no hand",
        "no head.tilt: it looks neither up",
        "no torso.turn",
        "no base.moves",
    ):
        assert lack in said
    assert "no head.pan" not in said
    assert found["joints"]["head.pan"]["range_deg"] == pytest.approx([-57.3, 57.3])
    assert "arms" not in run(f"agent check {pillar}").split("note")[0]


def test_an_eye_in_a_box_is_told_of(pillar: Path) -> None:
    boxed = '<visual><geometry><box size="0.3 0.3 0.3"/></geometry></visual>'
    robot = ROBOT.replace('<link name="base">', f'<link name="base">{boxed.replace("0.3 0.3 0.3", "0.3 0.3 2")}')
    pillar.with_name("pillar.urdf").write_text(robot)
    text = run(f"agent check {pillar}")
    assert "base hides 100.0% of its view; if that is the eye's own housing, add it to eye.exclude" in text


def test_every_problem_is_named_and_the_exit_code_says_no(pillar: Path) -> None:
    pillar.write_text(PROFILE.replace('"neck"', '"nekc"').replace('frame = "head"', 'frame = "haed"'))
    text = run(f"agent check {pillar}", exit_code=1)
    assert "not fit to use" in text
    assert "head.pan: no joint 'nekc'; did you mean 'neck'?\n" in text
    assert "eye.frame: no site or body 'haed'; did you mean 'head'?" in text
    assert text.count("problem ") == 2
    found = run_json(f"agent check {pillar}", exit_code=1)
    assert (found["fit"], len(found["problems"])) == (False, 2)


def test_known_names_are_listed_only_where_none_is_near(pillar: Path) -> None:
    pillar.write_text(PROFILE.replace('"neck"', '"xyz"').replace('frame = "head"', 'frame = "haed"'))
    text = run(f"agent check {pillar}", exit_code=1)
    assert "no joint 'xyz' (known: neck)" in text
    assert text.count("known:") == 1


def test_a_joint_about_the_wrong_axis_is_doubted(pillar: Path) -> None:
    pillar.write_text(PROFILE.replace("pan = {", "tilt = {"))
    text = run(f"agent check {pillar}")
    assert "pillar.toml: doubtful: is that meant?" in text
    assert "doubt     head.tilt: tilt looks up and down" in text


def test_no_picture_of_what_cannot_be_used(pillar: Path) -> None:
    pillar.write_text(PROFILE.replace('"neck"', '"nekc"'))
    picture = pillar.with_suffix(".png")
    assert "saved" not in run(f"agent check {pillar} -o {picture}", exit_code=1)
    assert not picture.exists()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("agent check pr3", ["no profile 'pr3'; did you mean 'pr2'?", "files (.toml)"]),
        ("agent check {}/none.toml", ["none.toml: cannot be read", "check the path"]),
        ("agent check human -o {}/a.jpg", ["a.jpg", "--out", "pictures are PNG"]),
        ("agent check human -o {}/nowhere/a.png", ["there is no folder", "--out"]),
    ],
)
def test_misuse_is_refused(tmp_path: Path, line: str, words: list[str]) -> None:
    message = refusal(line.format(tmp_path), tmp_path)
    for word in words:
        assert word in message


# --- Drafting.

CRANE = """<robot name="crane">
<link name="base"><collision><geometry><box size="0.3 0.3 0.4"/></geometry></collision></link>
{}</robot>"""
LINK = """<link name="l{0}">
<collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.05 0.05"/></geometry></collision></link>
<joint name="j{0}" type="revolute"><parent link="{1}"/><child link="l{0}"/><origin xyz="{2} 0 0.05"/>
<axis xyz="0 {3}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""


def crane(folder: Path) -> Path:
    links = [
        LINK.format(n, f"l{n - 1}" if n else "base", 0.2 if n else 0, "0 1" if n == 0 else "1 0") for n in range(5)
    ]
    path = folder / "crane.urdf"
    path.write_text(CRANE.format("".join(links)))
    return path


def test_a_draft_is_written_told_and_fit(tmp_path: Path) -> None:
    model, out = crane(tmp_path), tmp_path / "profiles" / "crane.toml"
    out.parent.mkdir()
    text = run(f"agent draft {model} -o {out}")
    assert text.startswith("crane.urdf: 6 bodies, 5 joints that turn and 0 that slide\n  arm from 'l0' to 'l4'")
    assert f"wrote {out}, the profile\nlook at it: taskgist agent check {out}" in text
    assert 'model = "../crane.urdf"' in out.read_text()
    found = run_json(f"agent check {out}")
    assert (found["fit"], found["eye"], found["hand"]) == (True, None, None)
    assert run(f"agent check {out} -o {tmp_path / 'crane.png'}").endswith("crane.png\n")


def test_what_a_draft_leaves_open_is_told(tmp_path: Path) -> None:
    model = crane(tmp_path)
    joint = '<joint name="c" type="fixed"><parent link="base"/><child link="camera_link"/></joint>'
    head = f'<link name="camera_link"/>{joint}'
    model.write_text(model.read_text().replace("</robot>", f"{head}</robot>"))
    found = run_json(f"agent draft {model} -o {tmp_path}/crane.toml")
    assert [each.partition(":")[0] for each in found["open"]] == ["eye.fov_deg"]
    text = run(f"agent draft {model} -o {tmp_path}/crane.toml --replace")
    assert "  open      eye.fov_deg: the model does not say how wide it sees" in text
    assert "fill in what it calls open, then: taskgist agent check" in text
    assert "eye.fov_deg: is missing" in run(f"agent check {tmp_path}/crane.toml", exit_code=1)


def test_a_draft_never_takes_the_place_of_a_file(tmp_path: Path) -> None:
    model = crane(tmp_path)
    (tmp_path / "crane.toml").write_text("mine")
    assert "--replace" in refusal(f"agent draft {model} -o {tmp_path}/crane.toml", tmp_path)
    assert (tmp_path / "crane.toml").read_text() == "mine"
    assert "profiles are TOML" in refusal(f"agent draft {model} -o {tmp_path}/crane.xml", tmp_path)
    assert "no such file" in refusal(f"agent draft {tmp_path}/crone.urdf -o {tmp_path}/new.toml", tmp_path)
