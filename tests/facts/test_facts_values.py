"""Values: unknown is one object and never a truth value; evidence is frozen plain data."""

from __future__ import annotations

import copy
import json
import pickle

import pytest

from taskgist.common.frozen import FrozenMap, Json, canonical_text, freeze, thaw
from taskgist.facts import UNKNOWN, Observation


def test_unknown_has_no_truth_value() -> None:
    with pytest.raises(TypeError, match="neither true nor false"):
        bool(UNKNOWN)


def test_unknown_stays_itself_through_pickle_and_copy() -> None:
    assert pickle.loads(pickle.dumps(UNKNOWN)) is UNKNOWN
    assert copy.deepcopy(UNKNOWN) is UNKNOWN
    assert repr(UNKNOWN) == "UNKNOWN"


def test_an_observation_is_frozen_through_and_through() -> None:
    angles = [0.1, 0.2]
    observation = Observation("Sitting", {"angles": angles, "by": {"knee": 1.0}})
    angles.append(9.0)
    assert observation.evidence["angles"] == (0.1, 0.2)
    assert isinstance(observation.evidence["by"], FrozenMap)
    assert hash(observation) == hash(pickle.loads(pickle.dumps(observation)))
    with pytest.raises(TypeError):
        observation.evidence["angles"] = 1  # type: ignore[index]


def test_an_observation_becomes_json() -> None:
    assert Observation(UNKNOWN).to_json() == {"value": None, "evidence": {}}
    hands = Observation({"left": None, "right": "Free_of_Object"}, {"gap_m": 0.2})
    expected = {"value": {"left": None, "right": "Free_of_Object"}, "evidence": {"gap_m": 0.2}}
    assert json.loads(json.dumps(hands.to_json())) == expected


def test_frozen_maps_change_into_copies() -> None:
    one = FrozenMap({"a": 1})
    assert one.set("b", 2) == {"a": 1, "b": 2}
    assert one.set("b", 2).without("a") == {"b": 2}
    assert one == {"a": 1}
    assert hash(FrozenMap({"a": 1, "b": 2})) == hash(FrozenMap({"b": 2, "a": 1}))
    assert copy.copy(one) == one


@pytest.mark.parametrize("value", [float("nan"), float("inf"), b"bytes", {1: "a"}, object()])
def test_only_json_can_be_evidence(value: Json) -> None:
    with pytest.raises(TypeError, match="not JSON"):
        freeze({"here": value})


def test_thaw_undoes_freeze() -> None:
    plain: Json = {"a": [1, {"b": None}], "c": "ü"}
    assert thaw(freeze(plain)) == plain
    assert canonical_text(freeze(plain)) == '{"a":[1,{"b":null}],"c":"ü"}'
