"""Drafting a profile: a robot's model is looked into, and a profile is written with a reason beside each line.

Nothing is settled that the model leaves open. What its tree of joints and its shapes tell is taken (``anatomy.py``),
what names tell is taken where the tree leaves a choice, and the rest is *open*: a line that its user fills in. A
profile without open lines can be used at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.text import clean_name
from taskgist.errors import InputError
from taskgist.world.bodies.fingers import HINGE, SLIDE, Plain
from taskgist.world.bodies.markup import asking_mujoco, parse_markup
from taskgist.world.bodies.model_files import add_model, find_file, is_urdf, name_problems, read_file, read_model
from taskgist.world.bodies.profile import examine_profile
from taskgist.world.bodies.urdf import Shapes
from taskgist.world.drafting.anatomy import Anatomy, anatomy
from taskgist.world.drafting.eye import Sensor, eye_lines
from taskgist.world.drafting.limbs import arm_lines, hand_lines, joint_lines
from taskgist.world.drafting.lines import Lines, listed, toml_value

KEY, PROFILE = "model.xml", "the profile"
KEYFRAMES = ("home", "rest", "stand", "standing")
"""Keyframes of an MJCF in which a robot rests."""
UNNAMED = "MuJoCo Model"


@dataclass(frozen=True, eq=False)
class Draft:
    """A profile that was drafted.

    Attributes:
        model: The file that was looked into.
        text: The profile, TOML.
        found: What was found in the model, a sentence each.
        open: What its user has to say, each with its field; empty if it can be used at once.
    """

    model: Path
    text: str
    found: tuple[str, ...]
    open: tuple[str, ...]


def draft_profile(model: str, *, named: str | None = None, near: Path | None = None) -> Draft:
    """Look into a robot's model, and draft a profile of it.

    Args:
        model: An MJCF or URDF file, or ``package://NAME/path``.
        named: How the profile names it; by default as it is given.
        near: Folder to which a file is relative; by default the working folder.

    Raises:
        SceneError: There is no such file, or it is no model.
    """
    path = find_file(model, near=near or Path(), where=model, field="model")
    spec, compiled, shapes, why = _loaded(path)
    found = anatomy(compiled)
    lines = Lines()
    lines.text.append(f"name = {toml_value(_name(spec, path))}")
    lines.text.append(f"model = {toml_value(named or model)}")
    if shapes != "visual":
        lines.say("shapes", shapes, why)
    eye_lines(lines, found, _sensors(path))
    joint_lines(lines, found)
    _rest_lines(lines, compiled)
    arms = arm_lines(lines, found)
    if arms:
        hand_lines(lines, found.tree, arms)
    else:
        lines.text.append("")
        lines.note("no [[arms]]: no hand, and no chain of five joints that turn; it reaches and grasps nothing")
    questions = [*lines.open, *_problems(lines, spec)]
    told = tuple(_told(found))
    head = [f"# What {path.name} holds:", *(f"# {line}" for line in told), *(f"# open: {each}" for each in questions)]
    text = "\n".join((*(" ".join(line.split()) for line in head), "", *lines.text)) + "\n"
    return Draft(path, text, told, tuple(questions))


def _problems(lines: Lines, spec: mujoco.MjSpec) -> Iterator[str]:
    """What keeps the profile from being used, beside what is open anyway."""
    profile, problems = examine_profile("\n".join(lines.text), where=PROFILE)
    asked = {each.partition(":")[0] for each in lines.open}
    yield from (_sentence(each) for each in problems if each.field not in asked)
    if profile is not None:
        yield from (_sentence(each) for each in name_problems(spec, profile, PROFILE))


def _sentence(problem: InputError) -> str:
    return str(problem).removeprefix(f"{PROFILE}: ")


def _loaded(path: Path) -> tuple[mujoco.MjSpec, mujoco.MjModel, Shapes, str]:
    """The model alone, with the shapes that can be read: those that are seen, else those that collide, and why."""
    try:
        return *_compiled(path, "visual"), "visual", ""
    except InputError as error:
        if not is_urdf(read_file(path)):
            raise
        try:
            return *_compiled(path, "collision"), "collision", f"its visual shapes cannot be used: {error.problem}"
        except InputError:
            raise error from None


def _compiled(path: Path, shapes: Shapes) -> tuple[mujoco.MjSpec, mujoco.MjModel]:
    files: dict[str, bytes] = {}
    add_model(path, KEY, files, shapes=shapes)
    spec = read_model(files, KEY, where=str(path), room=False)
    spec.assets = {name: data for name, data in files.items() if name != KEY}
    spec.compiler.balanceinertia = (
        True  # as where an agent is put into a scene: published inertias are often impossible
    )
    with asking_mujoco("MuJoCo cannot compile this model:", str(path)):
        return spec, spec.compile()


def _name(spec: mujoco.MjSpec, path: Path) -> str:
    name = clean_name(str(spec.modelname))
    return name if name and name != UNNAMED else path.stem


def _sensors(path: Path) -> list[Sensor]:
    """Cameras that a URDF describes for Gazebo."""
    text = read_file(path)
    if not is_urdf(text):
        return []
    found = []
    for gazebo in parse_markup(text, where=path).iter("gazebo"):
        for camera in gazebo.iter("camera"):
            texts = [camera.findtext(tag) for tag in ("horizontal_fov", "image/width", "image/height")]
            try:
                across, width, height = (float(each or "") for each in texts)
            except ValueError:
                continue
            if gazebo.get("reference") and 0.0 < across < np.pi and min(width, height) >= 1.0:
                found.append((str(gazebo.get("reference")), across, (int(width), int(height))))
    return found


def _rest_lines(lines: Lines, model: mujoco.MjModel) -> None:
    """Where joints rest: the model's own keyframe of that."""
    key = next((k for k in range(model.nkey) if str(model.key(k).name).lower() in KEYFRAMES), None)
    if key is None:
        return
    name = str(model.key(key).name)
    for table, kind, scale in (("[rest_deg]", HINGE, 180 / np.pi), ("[rest_m]", SLIDE, 1.0)):
        values = {
            str(model.joint(joint).name): round(scale * float(model.key_qpos[key][model.jnt_qposadr[joint]]), 3)
            for joint in range(model.njnt)
            if int(model.jnt_type[joint]) == kind
        }
        values = {joint: value for joint, value in values.items() if value and joint}
        if values:
            lines.table(table, f"the model's keyframe {name!r}")
            lines.text += [f"{toml_value(joint)} = {toml_value(value)}" for joint, value in values.items()]


# --- What was found, in sentences.


def _told(found: Anatomy) -> list[str]:
    tree = found.tree
    joints = [int(kind) for kind in tree.model.jnt_type]
    told = [
        f"{tree.model.nbody - 1} bodies, {joints.count(HINGE)} joints that turn and {joints.count(SLIDE)} that slide"
    ]
    for arm in found.arms:
        hand = "no fingers"
        if arm.fingers is not None:
            hand = arm.fingers.why
        if isinstance(arm.fingers, Plain):
            hand += f", opens {arm.fingers.fields['opening_m']:.3f} m"
        told.append(f"arm from {tree.name(arm.root)!r} to {tree.name(arm.hand)!r}, {len(arm.joints)} joints: {hand}")
    if found.eyes:
        told.append(f"eye: {listed([eye.name for eye in found.eyes])}")
    if found.aside:
        told.append(f"no eye: {listed([f'{name} ({why})' for name, why in found.aside])}")
    for what, chain in (("head", found.head), ("torso", found.torso)):
        if chain:
            told.append(f"{what}: {listed([tree.joint_name(joint) for joint in chain])}")
    if found.legs:
        told.append(f"legs: {len(found.legs)}, of {listed(sorted({str(len(leg)) for leg in found.legs}))} joints")
    if found.wheels:
        told.append(f"wheels: {listed(found.wheels)}")
    return told
