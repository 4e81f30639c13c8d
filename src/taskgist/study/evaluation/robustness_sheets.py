"""Robustness as tables of text: what worse demonstrations cost, and which rule bears them."""

from __future__ import annotations

from taskgist.study.evaluation.outcome import mean_f1
from taskgist.study.evaluation.robustness import Robustness
from taskgist.study.evaluation.rules import RULES
from taskgist.study.evaluation.setting import SETTINGS
from taskgist.study.evaluation.sheet import NONE, Sheet, mean_text, percent

SHOWN_AFTER = (5, 10)
"""Demonstrations after which robustness is shown."""


def robustness_sheet(found: Robustness, rule: str) -> Sheet:
    """All settings under one rule."""
    rows = []
    for setting in (each for each in SETTINGS if any(each.name == one.setting for one in found.outcomes)):
        outcome = found.outcome(setting.name, rule)
        after = {each.demonstrations: each for each in outcome.after}
        scores = [
            mean_text(getattr(after[count], score)) if count in after else NONE
            for count in SHOWN_AFTER
            for score in ("recall", "precision")
        ]
        same = mean_text(outcome.after[-1].recall_same)
        facts = NONE if setting.wrong_share else f"{found.changed[setting.condition]:.1%}"
        rows.append((setting.text, facts, percent(outcome.understood), *scores, same))
    shown = (f"{score} {count}" for count in SHOWN_AFTER for score in ("recall", "precision"))
    return Sheet(
        f"What worse demonstrations cost: rule {rule!r}, {RULES[rule].text}",
        ("setting", "facts", "Table 4", *shown, "same tracker"),
        tuple(rows),
        "facts: share of facts that changed; Table 4: share of draws that have all three in the end, mean over tasks; "
        "recall and precision of the clause after so many demonstrations, judged by clean ones; same tracker: recall "
        "after the most, judged by demonstrations watched in the same way.",
    )


def rules_sheet(found: Robustness) -> Sheet:
    """All rules: F1 in each setting, score, questions."""
    settings = tuple(dict.fromkeys(each.setting for each in found.outcomes))
    groups = {
        "clean": ["clean"],
        "noise": [each for each in settings if each.startswith("noise")],
        "lost, gap, label": [each for each in settings if each.startswith(("lost", "gap", "label"))],
        "wrong": [each for each in settings if each.startswith("wrong")],
    }
    groups = {name: members for name, members in groups.items() if members}
    same = "noise, same tracker"
    rows = []
    for rule, score in found.scores.items():
        by_group = {name: [found.outcome(each, rule) for each in members] for name, members in groups.items()}
        means = [percent(mean_f1(outcomes)) for outcomes in by_group.values()]
        means += [percent(mean_f1(by_group["noise"], same=True))] if "noise" in groups else []
        understood = percent(found.outcome(settings[0], rule).understood)
        rows.append((rule, RULES[rule].text, *means, f"{score:.1%}", f"{found.questions[rule]:.1f}", understood))
    return Sheet(
        "Rules, by score",
        ("rule", "what it is", *groups, *([same] if "noise" in groups else []), "score", "questions", "Table 4"),
        tuple(rows),
        "F1, mean over settings and over clauses from 3, 5, 10 and 20 demonstrations, judged by clean held-out "
        f"demonstrations ({same}: by those watched in the same way). Score: mean of clean, noise and wrong. Questions: "
        "asked for each task within the longest draw. Table 4: share of clean draws that have all three in the end.",
    )
