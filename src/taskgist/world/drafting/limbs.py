"""Joints, arms and hands of a drafted profile."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.agent import subtree
from taskgist.world.bodies.fingers import Plain
from taskgist.world.drafting.anatomy import LEFT, MOSTLY, RIGHT, Anatomy, FoundArm, Tree
from taskgist.world.drafting.lines import Lines, listed, rpy_of, toml_value

SAME_AXES = 0.98
"""Cosine within which axes are the same."""
SAME_PLACE_M = 0.005
"""How far points may be apart that are one (ours)."""
LEVEL_M = 0.05
"""How far a hand is beside an upright axis, at least, to point some way (ours)."""
PALM_BEHIND_M = 0.01
"""How far behind the tips things are held (ours)."""
NEAR_PALM_M = 0.03
"""How near a tool's frame is to the point between the tips to be meant (ours)."""
TOOL = re.compile(r"grasp|grip|tool|tcp|(^|_)ee(_|f|$)|attachment|flange|hand_frame")
"""Names of frames where a hand holds things."""
AZIMUTH_DEG, ELEVATION_DEG = (-60, 120), (-90, 80)
PEOPLES = "as people's arms; only the rough reach asks it (a setting)"


# --- Joints of head and torso, base and legs.


def joint_lines(lines: Lines, found: Anatomy) -> None:
    """The tables ``[head]``, ``[torso]``, ``[posture]`` and ``[base]``."""
    tree = found.tree
    _axes_lines(lines, tree, "head", found.head, ("pan", "tilt"), "moves the eye and no arm")
    what = "carries the arms and the eye" if found.eyes else "carries all arms"
    _axes_lines(lines, tree, "torso", found.torso, ("turn", "lean"), what)
    slides = [tree.joint_name(joint) for joint in tree.slides(found.torso)]
    if slides:
        lines.note(f"lifts the torso, without being named: {listed(slides)}")
    _posture_lines(lines, found)
    lines.table("[base]")
    moves, why = _moves(found)
    lines.say("moves", moves, why)


def _axes_lines(
    lines: Lines, tree: Tree, table: str, joints: Sequence[int], fields: tuple[str, str], what: str
) -> None:
    """A joint about the vertical and one across the body, where there are such."""
    turning = tree.turns(joints)
    upright = [joint for joint in turning if abs(tree.axis(joint)[2]) >= MOSTLY]
    across = [joint for joint in turning if abs(tree.axis(joint)[1]) >= MOSTLY]
    if not upright and not across:
        if turning:
            names = listed([tree.joint_name(joint) for joint in turning])
            lines.text.append("")
            lines.note(f"no [{table}]: {names} turn neither about the vertical nor across the body")
        return
    lines.table(f"[{table}]")
    for key, candidates, how in ((fields[0], upright, "upright"), (fields[1], across, "level, across the body")):
        if candidates:
            chosen = max(candidates, key=lambda joint: _span(tree, joint))
            others = [tree.joint_name(joint) for joint in candidates if joint != chosen]
            more = f"; it turns farthest of these: {listed(others)}" if others else ""
            why = f"{what}; its axis is {how}{more}"
            lines.say(key, {"joint": tree.joint_name(chosen)}, why)
    rest = [tree.joint_name(joint) for joint in turning if joint not in (*upright, *across)]
    if rest:
        lines.note(f"left at rest: {listed(rest)}")


def _span(tree: Tree, joint: int) -> float:
    low, high = tree.model.jnt_range[joint]
    return float(high - low) if tree.model.jnt_limited[joint] else 2 * math.pi


def _posture_lines(lines: Lines, found: Anatomy) -> None:
    """Hips, knees and ankles of two legs with three joints across the body each."""
    tree = found.tree
    bending = [[joint for joint in tree.turns(leg) if abs(tree.axis(joint)[1]) >= MOSTLY] for leg in found.legs]
    if len(bending) != 2 or any(len(leg) != 3 for leg in bending):
        return
    lines.table("[posture]", "it only stands; these bend its legs")
    lines.say("can", ["standing"], "say sitting where it sits, and thighs, feet and seat_share with it")
    for index, key in enumerate(("hips", "knees", "ankles")):
        why = f"joint {index + 1} of the three of each leg that turn across the body"
        lines.say(key, [tree.joint_name(leg[index]) for leg in bending], why)


def _moves(found: Anatomy) -> tuple[bool, str]:
    if found.wheels:
        return True, f"it has wheels: {listed(found.wheels)}"
    if found.legs:
        return True, f"it has {len(found.legs)} legs"
    if found.free:
        return True, "the model lets its root move"
    return False, "no wheels, no legs, and its root is fixed"


# --- Arms and hands.


def arm_lines(lines: Lines, found: Anatomy) -> tuple[FoundArm, ...]:
    """The ``[[arms]]`` tables; the arms that they name."""
    chosen, left_out = _two_arms(found.arms)
    tree = found.tree
    if left_out:
        names = listed([tree.name(arm.root) for arm in left_out])
        lines.text.append("")
        lines.note(f"open: a profile has one arm on each side; these are left out: {names}")
        lines.open.append(f"arms: which of them? left out: {names}")
    for side, arm, why in _sides(tree, chosen):
        lines.table("[[arms]]")
        lines.say("side", side, why)
        turning = len(tree.turns(arm.joints))
        sliding = len(arm.joints) - turning
        what = f"{turning} joints that turn" + (f" and {sliding} that slide" if sliding else "")
        lines.say("shoulder", *_shoulder(tree, arm))
        lines.say("root", tree.name(arm.root), f"{what} lead from here to the hand and to no other")
        hand_why = "the fingers hang on it" if arm.fingers is not None else "the last body that a joint moves"
        lines.say("hand", tree.name(arm.hand), hand_why)
        palm, palm_why = _palm(tree, arm)
        lines.say("palm", palm, palm_why)
        _carrier_lines(lines, tree, arm)
        azimuth, why = _azimuth(tree, arm, side) if len(chosen) == 1 else (AZIMUTH_DEG, PEOPLES)
        lines.say("azimuth_deg", azimuth, why)
        lines.say("elevation_deg", ELEVATION_DEG, PEOPLES)
    return chosen


def _two_arms(arms: tuple[FoundArm, ...]) -> tuple[tuple[FoundArm, ...], tuple[FoundArm, ...]]:
    """Those that the profile names, and the others: those with fingers first, the outermost of them."""
    if len(arms) <= 2:
        return arms, ()
    fingered = [arm for arm in arms if arm.fingers is not None] or list(arms)
    chosen = (fingered[0], fingered[-1]) if len(fingered) > 1 else (fingered[0],)
    return chosen, tuple(arm for arm in arms if arm not in chosen)


def _sides(tree: Tree, arms: tuple[FoundArm, ...]) -> list[tuple[str, FoundArm, str]]:
    """The side of each arm, and why."""
    if not arms:
        return []
    if len(arms) == 1:
        said = _said_side(tree, arms[0])
        if said:
            return [(said, arms[0], "by its name")]
        y = float(tree.data.xpos[arms[0].root][1])
        side = "left" if y > 0.05 else "right"
        return [(side, arms[0], "its only arm" if abs(y) <= 0.05 else f"its only arm, {abs(y):.2f} m aside")]
    named = [_said_side(tree, arm) for arm in arms]
    if sorted(named) == ["left", "right"]:
        placed = named == ["left", "right"]
        why = (
            "by its name"
            if placed
            else "by its name, though it lies on the other side of x: does the model look along x?"
        )
        return [(side, arm, why) for side, arm in zip(named, arms, strict=True)]
    return [(side, arm, f"the one farther to the {side}") for side, arm in zip(("left", "right"), arms, strict=True)]


def _said_side(tree: Tree, arm: FoundArm) -> str:
    """The side that an arm's names say; empty if they say none."""
    names = [tree.name(arm.root), tree.name(arm.hand), *(tree.joint_name(joint) for joint in arm.joints)]
    left = sum(bool(LEFT.search(name.lower()) or re.match(r"L[A-Z]", name)) for name in names)
    right = sum(bool(RIGHT.search(name.lower()) or re.match(r"R[A-Z]", name)) for name in names)
    if left == right or max(left, right) < len(names) / 2:
        return ""
    return "left" if left > right else "right"


def _azimuth(tree: Tree, arm: FoundArm, side: str) -> tuple[tuple[int, int], str]:
    """How far an only arm reaches about, across the body and outward: as its first joint turns, if that is upright."""
    first = arm.joints[0]
    if first not in tree.turns(arm.joints) or abs(tree.axis(first)[2]) < MOSTLY:
        return AZIMUTH_DEG, PEOPLES
    why = "as its first joint turns; only the rough reach asks it (a setting)"
    if not tree.model.jnt_limited[first]:
        return (-180, 180), why
    x, y, _ = tree.data.xpos[arm.hand] - tree.data.xanchor[first]
    if math.hypot(x, y) < LEVEL_M:  # it points up or down: which way it turns is not to be seen
        return AZIMUTH_DEG, PEOPLES
    now = float(tree.data.qpos[tree.model.jnt_qposadr[first]])
    turned = math.copysign(1.0, tree.axis(first)[2]) * (tree.model.jnt_range[first] - now)
    outward = 1.0 if side == "left" else -1.0
    low, high = sorted(outward * np.degrees(math.atan2(y, x) + turned))
    return (max(-180, int(low)), min(180, int(high))), why


def _shoulder(tree: Tree, arm: FoundArm) -> tuple[Any, str]:
    """The root's frame, moved to where the axes of its first joints meet, else to its first joint; and why."""
    name, turn = tree.name(arm.root), tree.data.xmat[arm.root].reshape(3, 3)
    met = _where_axes_meet(tree, tree.turns(arm.joints)[:3])
    at, why = (met, "where the axes of its first three joints meet") if met is not None else (None, "its first joint")
    offset = turn.T @ ((tree.data.xanchor[arm.joints[0]] if at is None else at) - tree.data.xpos[arm.root])
    return (name if np.linalg.norm(offset) < SAME_PLACE_M else {"frame": name, "offset_m": _metres(offset)}), why


def _where_axes_meet(tree: Tree, joints: Sequence[int]) -> Array | None:
    """The point of the first axis that is nearest to the others, if it is on them; None for fewer than three."""
    if len(joints) < 3:
        return None
    anchors, axes = tree.data.xanchor[list(joints)], tree.data.xaxis[list(joints)]
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]  # projections along each axis
    matrix = across.sum(axis=0)
    if np.linalg.cond(matrix) > 1e4:
        return None
    point = np.linalg.solve(matrix, np.einsum("nij,nj->i", across, anchors))
    off_m = np.linalg.norm(np.einsum("nij,nj->ni", across, point - anchors), axis=1)
    return np.asarray(point) if off_m.max() < SAME_PLACE_M else None


def _metres(vector: Array) -> list[float]:
    return [round(float(value), 4) + 0.0 for value in vector]


def _carrier_lines(lines: Lines, tree: Tree, arm: FoundArm) -> None:
    """What the arm hangs on, if its x looks ahead and its z up; else what carries it and does."""
    parent = int(tree.model.body_parentid[arm.root])
    at = parent
    while at and not _straight(tree, at):
        at = int(tree.model.body_parentid[at])
    if at and at != parent:
        why = f"the arm hangs on {tree.name(parent)!r}, whose x does not look ahead; this carries it"
        lines.say("carrier", tree.name(at), why)


def _straight(tree: Tree, body: int) -> bool:
    turn = tree.data.xmat[body].reshape(3, 3)
    return bool(turn[0, 0] >= MOSTLY and turn[2, 2] >= MOSTLY)


def _palm(tree: Tree, arm: FoundArm) -> tuple[Any, str]:
    """The frame where things are held, and why."""
    place, axes, why = _held_at(tree, arm)
    turn, origin = tree.data.xmat[arm.hand].reshape(3, 3), tree.data.xpos[arm.hand]
    at = origin + turn @ place
    name = _tool(tree, arm, at, None if axes is None else turn @ axes)
    if name:
        return name, f"a frame of the model {why}"
    frame: dict[str, Any] = {"frame": tree.name(arm.hand)}
    if np.linalg.norm(place) > 0.001:
        frame["offset_m"] = _metres(place)
    if axes is not None and not _along_axes(axes):
        frame["rpy_deg"] = [round(math.degrees(angle), 1) for angle in rpy_of(axes)]
    return (frame if len(frame) > 1 else tree.name(arm.hand)), why


def _held_at(tree: Tree, arm: FoundArm) -> tuple[Array, Array | None, str]:
    """Where things are held in the hand's frame, the hand's axes there if they are known, and why."""
    if isinstance(arm.fingers, Plain):
        place = arm.fingers.palm - PALM_BEHIND_M * arm.fingers.axes[:, 0]
        return place, arm.fingers.axes, "between the finger tips"
    turn, origin = tree.data.xmat[arm.hand].reshape(3, 3), tree.data.xpos[arm.hand]
    if arm.fingers is None:
        return np.zeros(3), None, "at the end of the arm"
    inside = subtree(tree.model, arm.hand)
    ends = [body for body in inside if len(subtree(tree.model, body)) == 1 and tree.joints_to(body)[-1:]]
    tips = [body for body in ends if tree.link_of(body) != tree.link_of(arm.hand)] or [arm.hand]
    middle = np.mean([tree.data.xpos[tip] for tip in tips], axis=0)
    return turn.T @ (middle - origin), None, "between the last links of the fingers: look at the picture"


def _tool(tree: Tree, arm: FoundArm, at: Array, axes: Array | None) -> str:
    """A frame of the hand's own link that is called a tool's and lies where things are held; of arms without, any."""
    model = tree.model
    link = tree.link_of(arm.hand)
    frames = [
        (tree.name(body), tree.data.xpos[body], tree.data.xmat[body])
        for body in subtree(model, arm.hand)
        if tree.link_of(body) == link and body != arm.hand
    ]
    frames += [
        (str(model.site(site).name), tree.data.site_xpos[site], tree.data.site_xmat[site])
        for site in range(model.nsite)
        if int(model.site_bodyid[site]) in subtree(model, arm.hand)
        and tree.link_of(int(model.site_bodyid[site])) == link
    ]
    fitting = []
    for name, place, matrix in frames:
        away = float(np.linalg.norm(place - at))
        near = arm.fingers is None or away < NEAR_PALM_M
        if name and TOOL.search(name.lower()) and near and (axes is None or _along_axes(matrix.reshape(3, 3).T @ axes)):
            fitting.append((away if arm.fingers is not None else -away, name))
    return min(fitting)[1] if fitting else ""


def _along_axes(axes: Array) -> bool:
    """Whether axes lie along those of a frame, whichever way."""
    return bool((np.abs(axes).max(axis=0) > SAME_AXES).all())


def hand_lines(lines: Lines, tree: Tree, arms: Sequence[FoundArm]) -> None:
    """The ``[hand]`` table: measured, or open, or none."""
    fingered = [arm for arm in arms if arm.fingers is not None]
    if not fingered:
        lines.text.append("")
        lines.note("no [hand]: no fingers in the model; it reaches, and grasps nothing")
        return
    plain = [arm.fingers for arm in fingered if isinstance(arm.fingers, Plain)]
    if len(plain) == len(fingered) and len(plain) == len(arms) and "palm_m" in plain[0].fields:
        names = listed([tree.name(arm.hand) for arm in fingered])
        lines.table("[hand]", f"{plain[0].why}, measured on {names}")
        for key, value in plain[0].fields.items():
            lines.say(key, list(value) if isinstance(value, tuple) else value, MEANT[key])
        differ = [
            key for each in plain[1:] for key, value in each.fields.items() if _differs(value, plain[0].fields.get(key))
        ]
        if differ:
            lines.note(f"the other hand measures otherwise: {listed(differ)}")
        return
    why = "; ".join(f"{tree.name(arm.hand)}: {arm.fingers.why}" for arm in fingered if arm.fingers is not None)
    measured = dict(plain[0].fields) if plain else {}
    lines.text.append("")
    lines.note(f"open: the hand is not plain ({why}): fill in and uncomment, or leave out: then it grasps nothing")
    lines.note("[hand]")
    kinds = "human: fingers against a thumb; parallel; three_finger: two against one"
    lines.text.append(f'# kind = "{measured.get("kind", "human")}"  # {kinds}')
    for key in ("opening_m", "finger_length_m", "finger_thickness_m", "palm_m"):
        given = toml_value(list(measured[key]) if key == "palm_m" else measured[key]) if key in measured else ""
        lines.text.append(f"# {key} = {given}  # {MEANT[key]}")
    lines.open.append(f"hand: not plain ({why}): give kind and sizes, or leave it out: then it grasps nothing")


def _differs(one: Any, other: Any) -> bool:
    if isinstance(one, str) or other is None:
        return bool(one != other)
    return bool(np.abs(np.subtract(one, other)).max() > 0.005)


MEANT = {
    "kind": "what faces what",
    "opening_m": "between the open fingers, at the pads",
    "finger_length_m": "from the palm to the tips",
    "finger_thickness_m": "along the closing direction",
    "finger_width_m": "across",
    "palm_m": "breadth across the fingers, and thickness along them",
    "spread_m": "from middle to middle of the two fingers side by side",
}
