"""Learning: from explanations of demonstrations to what a task means (section 6)."""

from taskgist.learning.answers import Answer, answer_from_json, in_force
from taskgist.learning.clause import Clause, Literal, clause_of
from taskgist.learning.estimate import Band, Estimate, Rule, Verdict, m_estimate, weigh
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Context, Explanation, explain, explanation_from_json
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.questions import Choice, Question, questions_of
from taskgist.learning.understanding import Judgement, Understanding, understand

__all__ = [
    "Answer",
    "Band",
    "Choice",
    "Clause",
    "Context",
    "Estimate",
    "Experience",
    "Explanation",
    "Judgement",
    "Knowledge",
    "Literal",
    "Question",
    "Rule",
    "Understanding",
    "Verdict",
    "answer_from_json",
    "clause_of",
    "explain",
    "explanation_from_json",
    "in_force",
    "m_estimate",
    "questions_of",
    "understand",
    "weigh",
]
