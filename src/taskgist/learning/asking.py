"""Asking: which question about a task would tell most, by what is known of it (6.4).

**The question.** After two demonstrations of *hide* many clauses are nearly as good: seeing becomes harder, or the
thing can hardly be seen, or it takes standing up to see it. A person knows which is meant. So the learner asks, and it
asks first what it would learn most from.

**Hypotheses.** The posterior holds the forty best clauses ``c`` with their weights ``w``. A clause says what sets the
task apart; what else may be meant beside it, such as that the thing ends on a support as most things do, it leaves
open. A literal ``Q`` that a clause leaves open is meant, too, with the odds by which the clause gets better or worse
with it::

    odds(Q | c) = exp(score(c ∧ Q) − score(c)),    and the same of its complement ¬Q

which is the size principle again: what always was so, and seldom is in the background where ``c`` holds, is likely
meant.

**Answers.** If ``c`` entails ``Q`` (``entailment``) the answer is *yes*, if it contradicts it *no*; if it leaves it
open, *yes*, *no* or *either* (it does not matter) by these odds. Each hypothesis, which is a clause and what is meant
beside it, fixes the answer of a person who knows the task.

**Information.** What an answer is worth is the information that it is expected to give (Lindley 1956). About the
hypotheses themselves that is the entropy of the answer, because each fixes it. But much of that would be idle:
whether an effort lies at most one rung below the top decides nothing in any room. What is asked for is what a robot
will do with it: tell whether the task was done. So it is the *mean marginal information gain* (MacKay 1992,
"Information-based objective functions for active data selection"): the mutual information of the answer ``a`` and of
whether the task is done in a demonstration ``x``, as a mean over those that are known, the task's own and each kind
of background weighing the same, in bits::

    gain(Q) = mean over x of [ H(T(x)) − Σ_a p(a) H(T(x) | a) ],    p(T(x) | a) = Σ_h p(h | a) [h holds in x]

*Don't know* tells nothing. If a share of people does not know, all questions lose that share of their gain, and their
order stays.

**What was asked** is not asked again: not in other words (another literal of the same worlds, or its complement), nor
what follows from answers that hold. A question below ``LEAST_GAIN`` is not worth anybody's time: then nothing is left
to ask.

**Words.** Nobody can say whether a thing filled 2 % of an image: of scores it is only asked whether next to nothing
was seen; of ladders, whether it takes at least, at most, or just this effort. What must not be, and how great an
effort must be, is asked only where it tells twice as much (``HARDER``), and what is nearly always so anyway is not
asked (``EVIDENT``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import NEGLIGIBLE
from taskgist.learning.answers import Reply, set_id
from taskgist.learning.clauses import (
    EQUAL,
    FOLLOWING_BITS,
    NOTHING_TOLD,
    ClausePosterior,
    Counting,
    Support,
    Told,
    WeighedClause,
    clause_score,
)
from taskgist.learning.entailment import Worlds, entailment_of
from taskgist.learning.evidence import Evidence
from taskgist.learning.literals import LADDERS, SetLiteral, Vocabulary, vocabulary_by_node

LEAST_GAIN = 0.002
"""Gain below which a question is not asked, bits for each demonstration."""
EVIDENT = 0.95
"""Of what is so in this share of the background, or is not, nobody is asked whether it must be so."""
HARDER = 0.5
"""What a question is worth that asks what must not be, or how great an effort must be, beside a plain one that tells as
much: people mean such things less often than the literals' description lengths say, and find them harder to answer."""
DECIDED = (Reply.YES, Reply.NO)
SURE = 30.0
"""Natural logarithm of odds beyond which nothing changes."""


@dataclass(frozen=True)
class SetQuestion:
    """Must this be so?

    Args:
        task: The task.
        literal: What is asked about.
        support: How often it holds, and by chance.
        expected: Probability of each answer of a person who knows the task.
        gain: Expected information on whether the task is done, mean over demonstrations, bits.
        contrast: The same of a demonstration in which the literal fails, asked for instead: it is shown, or cannot be.
    """

    task: str
    literal: SetLiteral
    support: Support
    expected: Mapping[Reply, float]
    gain: float
    contrast: float = 0.0

    @property
    def id(self) -> str:
        """Identifier of what is asked about, as ``Answer.about``."""
        return question_id(self.literal)


def question_id(literal: SetLiteral) -> str:
    """Identifier of a question about a literal."""
    return set_id(literal.node, literal.values, but=literal.but)


class Known(Enum):
    """What follows of a set of worlds."""

    YES = "yes"
    NO = "no"
    OPEN = "open"


class Asking:
    """What there is to ask about one task.

    Args:
        evidence: What the posterior was learned from.
        posterior: What ``learn_clauses`` found in it.
        tree: Whose effects literals are about.
        told: What people have said already, which the posterior was learned with.
        asked: What they were asked, those included that they do not know.
    """

    def __init__(
        self,
        evidence: Evidence,
        posterior: ClausePosterior,
        tree: HypothesisTree,
        told: Told = NOTHING_TOLD,
        asked: Iterable[SetLiteral] = (),
    ) -> None:
        self.posterior, self.tree, self.told = posterior, tree, told
        self.evidence = evidence
        self.counting = Counting(evidence, posterior.task)
        self.entailment = entailment_of(tree)
        self.vocabularies = vocabulary_by_node(tree)
        self._must = self.entailment.together(told.fixed(tree))
        self._free = [self.entailment.worlds(each) for each in told.free]
        self._asked = {self._key(self.entailment.worlds(each)) for each in (*asked, *told.free)}
        self._clauses = [
            (clause, self.entailment.together(clause.literals), self.counting.truth(clause.literals))
            for clause in posterior.clauses
        ]
        self.alike = self.counting.alike(true for _, _, (true, _) in self._clauses)

    @property
    def alone(self) -> bool:
        """Whether there is nothing to compare the task with, so that nothing tells what is worth asking."""
        return len(self.evidence.kinds) == 1

    def questions(self) -> tuple[SetQuestion, ...]:
        """The questions that are worth asking, the most useful one first; none: nothing is left, or it is ``alone``."""
        if self.alone:
            return ()
        useful = [each for each in map(self.question, self.literals()) if each.gain >= LEAST_GAIN]
        return tuple(sorted(useful, key=lambda each: (-round(self._worth(each), EQUAL), each.literal.order)))

    def _worth(self, question: SetQuestion) -> float:
        """Gain of a question, less where it is a harder one."""
        plain = not (question.literal.but or self.vocabularies[question.literal.node].ladder)
        return question.gain * (1.0 if plain else HARDER)

    def literals(self) -> Iterator[SetLiteral]:
        """What may be asked about, each once, so that it held in one half of the demonstrations, or more."""
        done = set(self._asked)
        for vocabulary in self.vocabularies.values():
            if vocabulary.node.name in self.told.irrelevant:
                continue
            seen = self.evidence.seen(vocabulary.node.name, self.posterior.task)
            for literal in sorted(vocabulary.literals(seen), key=lambda each: not each.is_value):
                worlds = self.entailment.worlds(literal)
                key = self._key(worlds)
                if key not in done and _speakable(literal, vocabulary) and self._is_open(worlds):
                    done.add(key)
                    support = self.counting.support(*self.counting.truth((literal,)))
                    if 1.0 - EVIDENT < support.chance < EVIDENT:
                        yield literal if 2 * support.k >= support.n else vocabulary.complement(literal)

    def question(self, literal: SetLiteral) -> SetQuestion:
        """The question about a literal, and what it tells."""
        complement = self.vocabularies[literal.node].complement(literal)
        worlds = self.entailment.worlds(literal)
        possible = {
            reply: meant for reply, meant in ((Reply.YES, literal), (Reply.NO, complement)) if self._possible(meant)
        }
        by_clause = [self._foreseen(*each, worlds, possible) for each in self._clauses]
        weights = [clause.weight for clause in self.posterior.clauses]
        expected = {
            reply: math.fsum(weight * each[reply] for weight, each in zip(weights, by_clause, strict=True))
            for reply in (Reply.YES, Reply.NO, Reply.EITHER)
        }
        truth = self.counting.truth((literal,))
        gain, contrast = (self._gain(truth, by_clause, shown=shown) for shown in (False, True))
        return SetQuestion(self.posterior.task, literal, self.counting.support(*truth), expected, gain, contrast)

    def _foreseen(
        self,
        clause: WeighedClause,
        meaning: Mapping[str, int],
        truth: tuple[int, int],
        worlds: Worlds,
        possible: Mapping[Reply, SetLiteral],
    ) -> dict[Reply, float]:
        """Probability of each answer if a clause is what the task is about."""
        known = _known(meaning.get(worlds.space, self.entailment.all(worlds.space)), worlds.bits)
        if known is not Known.OPEN:
            return {Reply.YES: float(known is Known.YES), Reply.NO: float(known is Known.NO), Reply.EITHER: 0.0}
        odds = {reply: self._odds(clause, truth, possible[reply]) if reply in possible else 0.0 for reply in DECIDED}
        total = 1.0 + math.fsum(odds.values())
        return {**{reply: each / total for reply, each in odds.items()}, Reply.EITHER: 1.0 / total}

    def _gain(self, truth: tuple[int, int], by_clause: Sequence[Mapping[Reply, float]], *, shown: bool) -> float:
        """Mean marginal information gain of a question, bits for each demonstration.

        Args:
            truth: Where its literal holds, and where it fails.
            by_clause: Probability of each answer by clause.
            shown: Whether it is answered by a demonstration in which the literal fails, or by there being none: *no*
                and *either* look the same then.
        """
        joint = [
            {reply: clause.weight * each[reply] for reply in each}
            for (clause, _, _), each in zip(self._clauses, by_clause, strict=True)
        ]
        answers = {reply: math.fsum(each[reply] for each in joint) for reply in (*DECIDED, Reply.EITHER)}
        total = 0.0
        for same, holding in self.alike:
            by_answer = {reply: math.fsum(joint[index][reply] for index in holding) for reply in answers}
            for holds, part in ((True, same & truth[0]), (False, same & truth[1])):
                share = self.counting.share(part)
                if share:
                    done = by_answer | {Reply.NO if holds else Reply.YES: 0.0}
                    outcomes = [(done[reply], answers[reply]) for reply in answers]
                    if shown:
                        (cannot, *can) = outcomes
                        outcomes = [cannot, (math.fsum(each for each, _ in can), math.fsum(each for _, each in can))]
                    total += share * _information(outcomes)
        return total

    def _odds(self, clause: WeighedClause, truth: tuple[int, int], literal: SetLiteral) -> float:
        """Odds that a literal which a clause leaves open is meant beside it."""
        true, false = self.counting.truth((literal,))
        support = self.counting.support(truth[0] & true, truth[1] | false)
        bits = math.fsum(FOLLOWING_BITS + each.bits for each in (*clause.literals, literal))
        gain = clause_score(support, bits) - clause.score
        return math.exp(max(-SURE, min(SURE, gain)))

    def _key(self, worlds: Worlds) -> tuple[str, int]:
        """The same for a set and its complement, and for all words for them."""
        return worlds.space, min(worlds.bits, self.entailment.all(worlds.space) & ~worlds.bits)

    def _is_open(self, worlds: Worlds) -> bool:
        """Whether what was told leaves it open."""
        must = self._must.get(worlds.space, self.entailment.all(worlds.space))
        return _known(must, worlds.bits) is Known.OPEN

    def _possible(self, literal: SetLiteral) -> bool:
        """Whether it may be meant: none that was told to be free would hold in all of it, or in none."""
        worlds = self.entailment.worlds(literal)
        left = worlds.bits & self._must.get(worlds.space, worlds.bits)
        return all(left & each.bits not in (0, left) for each in self._free if each.space == worlds.space)


def _known(own: int, asked: int) -> Known:
    if own and not own & ~asked:
        return Known.YES
    return Known.OPEN if own & asked else Known.NO


def _speakable(literal: SetLiteral, vocabulary: Vocabulary) -> bool:
    """Whether people can say if it is so."""
    if vocabulary.ladder and vocabulary.ladder not in LADDERS:
        return literal.values == (NEGLIGIBLE,)
    return literal.bound != "to"


def _information(outcomes: Sequence[tuple[float, float]]) -> float:
    """Mutual information of an outcome and whether the task is done, bits.

    Args:
        outcomes: Of each, the probability of it and that the task is done, and that of it.
    """
    given = math.fsum(each * entropy(done / each) for done, each in outcomes if each > 0.0)
    return max(0.0, entropy(math.fsum(done for done, _ in outcomes)) - given)


def entropy(probability: float) -> float:
    """Entropy of whether something is so, in bits."""
    if not 0.0 < probability < 1.0:
        return 0.0
    return -probability * math.log2(probability) - (1.0 - probability) * math.log2(1.0 - probability)


def told_by(replies: Sequence[tuple[SetLiteral, Reply]], tree: HypothesisTree) -> Told:
    """What answers about sets of values fix."""
    known = vocabulary_by_node(tree)
    must = [literal for literal, reply in replies if reply is Reply.YES]
    must += [known[literal.node].complement(literal) for literal, reply in replies if reply is Reply.NO]
    free = [literal for literal, reply in replies if reply is Reply.EITHER]
    return Told(must=tuple(must), free=tuple(free))
