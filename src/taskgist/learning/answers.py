"""Answers: what people said about predicates that the demonstrations left open (6.4).

Answers are kept as evidence with author and time, and none is ever thrown away: who changes their mind gives a later
answer, and withdrawing is such a statement, too. So the answers of two knowledge files merge by union.

**About a node**, as the paper asks: it is relevant, with this value, or irrelevant.

**About a set of values**, as whole clauses ask: *must the object end on a support?* Let ``S`` be the set that was asked
about, and ``A`` the values of that node with which the task is done as it should be. The answers are the three ways in
which two sets can lie, and a fourth one:

- *yes*: it must be so; ``A`` lies in ``S``;
- *no*: it must not be so; ``A`` and ``S`` have nothing in common;
- *either*: it need not be so, and may; neither of both;
- *don't know*: it says nothing, and is not asked again.

For the paper's rule, which knows single values alone, *yes* to one value makes the node relevant with that value, *no*
to one of two values makes it relevant with the other one, and *either* to one value makes it irrelevant. Everything
else leaves its verdict as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from datetime import datetime
from enum import Enum
from pathlib import Path

from taskgist.common.frozen import Json
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.tree import TreeOf, tree_of
from taskgist.learning.estimate import Verdict

DECISIONS = (Verdict.RELEVANT, Verdict.IRRELEVANT)


class Reply(Enum):
    """What a person says to a question about a set of values."""

    YES = "yes"
    NO = "no"
    EITHER = "either"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Answer:
    """One statement about a node, or about a set of its values. It holds until a later one replaces or withdraws it.

    Args:
        task: Name of the task.
        node: Name of the node.
        verdict: Relevant or irrelevant, of the whole node; None withdraws what was said before, or stands beside a set.
        value: Desired value where relevant; None takes the one observed most often.
        author: Who said so.
        time: When, in ISO 8601 with the offset from UTC: ``"2024-05-01T12:00:00+00:00"``.
        tree_of: Whose tree the node is in.
        among: The set of values that was asked about; none: the answer is about the node.
        but: Whether the set is all values but those.
        reply: What was said of the set; None withdraws what was said of it before.
        own: Whether it withdraws what its author said alone; otherwise what anybody said.

    Raises:
        KnowledgeError: The verdict is none that a person can give, a value comes without relevance, a reply without a
            set or a verdict beside one, what is said counts as withdrawn by its author, or the time cannot be read.
        UnknownNameError: It is nobody's tree.
    """

    task: str
    node: str
    verdict: Verdict | None
    author: str
    time: str
    value: str | None = None
    tree_of: TreeOf = "target"
    among: tuple[str, ...] = ()
    but: bool = False
    reply: Reply | None = None
    own: bool = False

    def __post_init__(self) -> None:
        where = f"answer on {self.task}"
        if self.verdict is not None and self.verdict not in DECISIONS:
            hint = "say relevant or irrelevant, or withdraw with None"
            raise KnowledgeError("no decision", where=where, field=self.node, value=self.verdict.value, hint=hint)
        if self.value is not None and self.verdict is not Verdict.RELEVANT:
            hint = "only a relevant node has a desired value"
            raise KnowledgeError("value without relevance", where=where, field=self.node, value=self.value, hint=hint)
        if self.among and self.verdict is not None:
            hint = "of a set say yes, no, either or unknown; of a node relevant or irrelevant"
            raise KnowledgeError("verdict on a set of values", where=where, field=self.node, hint=hint)
        if not self.among and (self.reply is not None or self.but):
            hint = "name the values that it is about (among)"
            raise KnowledgeError("reply without a set of values", where=where, field=self.node, hint=hint)
        if self.own and not self.withdraws:
            hint = "withdraw with neither verdict nor reply"
            raise KnowledgeError("withdraws nothing", where=where, field="own", value=self.own, hint=hint)
        object.__setattr__(self, "among", tuple(sorted(set(self.among))))
        _instant(self.time, where)
        tree_of(self.tree_of)

    @property
    def withdraws(self) -> bool:
        """Whether it takes back what was said before."""
        return self.verdict is None and self.reply is None

    @property
    def second(self) -> str:
        """When it was said, to the second, as people are told it."""
        return _instant(self.time, self.node).isoformat(timespec="seconds")

    @property
    def about(self) -> str:
        """What it is about: the node, or ``set_id`` of a set of its values."""
        return set_id(self.node, self.among, but=self.but) if self.among else self.node

    def exact(self, values: Sequence[str]) -> Answer | None:
        """What it says of its node as a whole; None if it leaves that open.

        Args:
            values: Declared values of the node; none if it may take any.
        """
        if not self.among:
            return self
        asked = set(values) - set(self.among) if self.but else set(self.among)
        others = set(values) - asked
        plain = replace(self, among=(), but=False, reply=None)
        if self.reply is Reply.EITHER and len(asked) == 1:
            return replace(plain, verdict=Verdict.IRRELEVANT)
        meant = {Reply.YES: asked, Reply.NO: others}.get(self.reply or Reply.UNKNOWN, set())
        return replace(plain, verdict=Verdict.RELEVANT, value=next(iter(meant))) if len(meant) == 1 else None

    def to_json(self) -> dict[str, Json]:
        """Plain data; ``answer_from_json`` reads it back."""
        plain: dict[str, Json] = {
            each.name: getattr(self, each.name) for each in fields(self) if each.name not in ("among", "but", "reply")
        }
        if not self.own:
            del plain["own"]  # which earlier releases do not know
        if self.tree_of == "target":
            del plain["tree_of"]  # as those of earlier releases, which know no other, are kept
        if self.among:  # which earlier releases do not know
            reply = self.reply.value if self.reply else None
            plain |= {"among": list(self.among), "but": self.but, "reply": reply}
        return {**plain, "verdict": self.verdict.value if self.verdict else None}


def answer_from_json(document: object, *, where: str | Path | None = None) -> Answer:
    """Read back what ``Answer.to_json`` gave.

    Raises:
        KnowledgeError: Something is missing, further, or of another kind.
    """
    hint = "restore the file from a copy"
    try:
        data = dict(document)  # type: ignore[call-overload] # what does not fit is caught below
        verdict = data.pop("verdict")
        about = {name: data.pop(name) for name in ("among", "but", "reply")} if "among" in data else {}
        own = data.pop("own", False)
        if not isinstance(own, bool):
            raise TypeError("own: neither true nor false")
        strange = [name for name, text in data.items() if not isinstance(text, str) and (name, text) != ("value", None)]
        if strange:
            raise TypeError(f"{', '.join(strange)}: no text")
        if about:
            among, but, reply = about["among"], about["but"], about["reply"]
            if not isinstance(among, list) or not among or not all(isinstance(each, str) for each in among):
                raise TypeError("among: no list of texts")
            if not isinstance(but, bool):
                raise TypeError("but: neither true nor false")
            data |= {"among": tuple(among), "but": but, "reply": None if reply is None else Reply(reply)}
        return Answer(verdict=None if verdict is None else Verdict(verdict), own=own, **data)
    except (KeyError, TypeError, ValueError, UnknownNameError) as error:
        raise KnowledgeError(f"not an answer: {error!r}", where=where, hint=hint) from error


def set_id(node: str, values: Iterable[str], *, but: bool = False) -> str:
    """Identifier of a set of values: ``"placement.status.2=On_Support"``; ``!=`` where it is all but these."""
    return f"{node}{'!=' if but else '='}{'|'.join(sorted(values))}"


def in_force(answers: Iterable[Answer]) -> dict[str, Answer]:
    """The answer that holds for each node: the latest one about the node as a whole that was not withdrawn since."""
    found: dict[str, list[Answer]] = {}
    for answer in sorted((each for each in answers if not each.among), key=_order):
        of_node = found.setdefault(answer.node, [])
        if answer.withdraws:
            of_node[:] = [each for each in of_node if answer.own and each.author != answer.author]
        else:
            of_node.append(answer)
    return {node: of_node[-1] for node, of_node in found.items() if of_node}


def replies_in_force(answers: Iterable[Answer]) -> tuple[Answer, ...]:
    """What holds of sets of values: the latest answer of each author on each set, unless it was withdrawn since.

    Anybody's withdrawal takes back all that was said of a set until then, or only what its author said. Whoever says
    *don't know* after others have decided changes nothing. Sorted by set and time.
    """
    found: dict[str, dict[str, Answer]] = {}
    for answer in sorted((each for each in answers if each.among), key=_order):
        of_set = found.setdefault(answer.about, {})
        if answer.withdraws and answer.own:
            of_set.pop(answer.author, None)
        elif answer.withdraws:
            of_set.clear()
        else:
            of_set[answer.author] = answer
    return tuple(each for about in sorted(found) for each in sorted(found[about].values(), key=_order))


def _order(answer: Answer) -> tuple[datetime, str, str, str, str]:
    """Time decides; what was said at the same instant has an order all the same."""
    verdict = answer.verdict.value if answer.verdict else ""
    reply = answer.reply.value if answer.reply else ""
    return (_instant(answer.time, answer.node), answer.author, verdict, answer.value or "", reply)


def _instant(time: str, where: str) -> datetime:
    hint = "write it like 2024-05-01T12:00:00+00:00"
    try:
        instant = datetime.fromisoformat(time)
    except (TypeError, ValueError) as error:
        raise KnowledgeError("not a time", where=where, field="time", value=time, hint=hint) from error
    if instant.tzinfo is None:
        raise KnowledgeError("no offset from UTC", where=where, field="time", value=time, hint=hint)
    return instant
