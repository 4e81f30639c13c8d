"""``taskgist ask``: what a task's demonstrations leave open, asked and answered."""

from __future__ import annotations

import getpass
import json
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.clauses import answer_document, compared_document
from taskgist.cli.common import (
    KNOWLEDGE,
    JsonOption,
    KnowledgeOption,
    about,
    command,
    console,
    print_json,
    task_named,
)
from taskgist.errors import InputError, KnowledgeError, UnknownNameError
from taskgist.facts.predicates import with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, TreeOf, tree_of
from taskgist.language.asking import MEANINGS, against_all, answer_text, lesson_text, question_text, sides_text
from taskgist.learning.answers import Answer, Reply, in_force, replies_in_force
from taskgist.learning.asking import SetQuestion, question_id
from taskgist.learning.explanation import Context
from taskgist.learning.lessons import OtherEnd, OtherStart, lessons_of
from taskgist.learning.literals import SetLiteral, vocabulary_by_node
from taskgist.learning.task_clauses import answers_against_all, learn_task, open_questions, sides
from taskgist.settings import DEFAULT

if TYPE_CHECKING:  # with MuJoCo
    from taskgist.learning.knowledge import Knowledge

FURTHER = 3
"""Further questions that are told in text."""
FOLDED = (Reply.YES, Reply.NO, Reply.EITHER)


@command
def ask(
    task: Annotated[str, typer.Argument(help="The task.", show_default=False)],
    knowledge: KnowledgeOption = KNOWLEDGE,
    answer: Annotated[
        str | None,
        typer.Option(help='yes, no, either, unknown; or a document: {"question": "...", "answer": "yes"}.'),
    ] = None,
    question: Annotated[
        str | None, typer.Option(help="The question that is answered or withdrawn, by its id; default: the first one.")
    ] = None,
    withdraw: Annotated[bool, typer.Option("--withdraw", help="Take back what was said to --question.")] = False,
    author: Annotated[
        str | None,
        typer.Option(
            help="Who answers, the user's name by default; with --withdraw: whose answer, everybody's by default."
        ),
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="List the answers that hold.")] = False,
    of: Annotated[str, typer.Option(help="Whose tree: target or performer.")] = "target",
    as_json: JsonOption = False,
) -> None:
    """Ask what the demonstrations of a task leave open.

    The most useful question comes first: the one whose answer is expected to tell most about whether the task is done
    in a demonstration. With it: where it was so, where it was not, what each answer would make of the task's meaning,
    and which further demonstration would teach most.

    It asks nothing as long as there is nothing to compare the task with: learn another one.

    Answers: yes (it must be so), no (it must not), either (it does not matter), unknown (it is not asked again). An
    answer holds until it is withdrawn, by anybody, or with --author as that author's alone; one that contradicts
    another is refused. Both rules of explain respect it, the paper's where it settles one value.

    For a dialogue: --json gives the question with its id, and the JSON Schema of its answer, which --answer takes.

    Example: taskgist ask hide -k knowledge.db

    Example: taskgist ask hide --answer yes --author ann

    Example: taskgist ask hide --withdraw --question see.class=Becomes_Difficult
    """
    tree, whose = with_predicates(STANDARD_TREE), tree_of(of)
    if listed and (answer is not None or withdraw):
        given = "--answer" if answer is not None else "--withdraw"
        hint = f"leave one of --list and {given} out: {given} tells what holds by then, with --json"
        raise KnowledgeError("only lists", field="--list", hint=hint)
    if withdraw and (answer is not None or question is None):
        problem = "withdraws and answers at once" if answer is not None else "which answer?"
        hint = "taskgist ask TASK --withdraw --question ID; --list shows the answers that hold"
        raise KnowledgeError(problem, field="--withdraw", hint=hint)
    if question is not None and answer is None and not withdraw:
        hint = "say what is answered: --answer yes, no, either or unknown; or --withdraw"
        raise KnowledgeError("what is the answer?", field="--question", value=question, hint=hint)
    reply, told = (None, None) if answer is None else _read(answer)
    if told is not None and question is not None and told != question:
        raise KnowledgeError("answers another question", field="--question", value=question, hint=f"it says {told}")
    from taskgist.store.address import shown  # with sqlalchemy, which only knowledge should wait for
    from taskgist.store.database import load, update

    known = load(knowledge, expected=Context.of(DEFAULT, tree))
    with about(shown(knowledge), {"of": "--of"}):
        name = task_named(known, task)
        whose = known.experience(name, whose).tree_of
        noted = None
        if answer is not None or withdraw:
            noted = _said(known, name, tree, whose, reply, told or question, author)
            answered = known.answer(noted)
            if not withdraw:
                learn_task(answered, name, tree, whose)  # refuses what contradicts itself, before it is kept
            update(knowledge, answers=[noted])
            known = answered
        if listed and not as_json:  # of answers that contradict each other, too
            _print_answers(known, name, tree, whose)
            return
        document = _document(known, name, tree, whose, noted)
        count = len(known.experience(name, whose).explanations)
    print_json(document) if as_json else _print(document, count)


def _said(
    known: Knowledge,
    task: str,
    tree: HypothesisTree,
    of: TreeOf,
    reply: Reply | None,
    question: str | None,
    author: str | None,
) -> Answer:
    """The answer that was given on the command line; without a reply, what withdraws it."""
    if reply is None:
        return _withdrawal(known, task, of, question or "", author, tree)
    if question is None:
        asking = open_questions(known, task, tree, of)
        questions = asking.questions()
        if not questions:
            problem = (
                "nothing can be compared yet, so that nothing is asked" if asking.alone else "nothing is left to ask"
            )
            hint = "name what it is about: --question ID"
            raise KnowledgeError(problem, where=f"task {task}", field="--answer", hint=hint)
        literal = questions[0].literal
    else:
        literal = _literal(question, tree)
    return Answer(task, literal.node, None, author or _user(), _now(), None, of, literal.values, literal.but, reply)


def _withdrawal(
    known: Knowledge, task: str, of: TreeOf, wanted: str, author: str | None, tree: HypothesisTree
) -> Answer:
    """What takes back the answers to a question: everybody's, or those of an author."""
    holding = {each.about: each for each in _holding(known, task, of) if author in (None, each.author)}
    if wanted not in holding and "=" in wanted:
        literal = _literal(wanted, tree)  # in other words, or another order of its values
        wanted = question_id(literal)
    if wanted not in holding:
        raise UnknownNameError("answer to" if author is None else f"answer of {author} to", wanted, holding)
    held = holding[wanted]
    own = author is not None
    return Answer(task, held.node, None, author or _user(), _now(), None, of, held.among, held.but, own=own)


def _read(given: str) -> tuple[Reply, str | None]:
    """A word, or a document with a word and the question that it answers."""
    hint = f"one of {', '.join(reply.value for reply in Reply)}; or a document as --json's answer_schema says"
    word: Any = given.strip()
    told: Any = None
    if word.startswith("{"):
        try:
            document = json.loads(word)
        except (ValueError, RecursionError) as error:
            raise InputError(f"no JSON: {error}", field="--answer", value=given[:80], hint=hint) from error
        word, told = document.pop("answer", None), document.pop("question", None)
        if document or not isinstance(word, str) or not isinstance(told, str):
            raise InputError("not an answer", field="--answer", value=given[:80], hint=hint)
    try:
        return Reply(word), told
    except ValueError as error:
        raise InputError("no answer to a question", field="--answer", value=word, hint=hint) from error


def _literal(wanted: str, tree: HypothesisTree) -> SetLiteral:
    """The literal of a question's id."""
    node, sign, rest = wanted.partition("=")
    but, node = node.endswith("!"), node.removesuffix("!")
    known = vocabulary_by_node(tree)
    if node not in known:
        raise UnknownNameError("question about", node or wanted, known)
    if not sign:
        hint = f"name one, such as {node}={next(iter(known[node].values))}"
        raise KnowledgeError("names no value", field="--question", value=wanted, hint=hint)
    values = rest.split("|")
    for value in values:
        if value not in known[node].values:
            raise UnknownNameError(f"value of {node}", value, known[node].values)
    if len(set(values)) == len(known[node].values):
        raise KnowledgeError("asks about all values", field="--question", value=wanted, hint="leave one of them out")
    return known[node].literal(values, but=but)


def _now() -> str:
    return datetime.now(UTC).isoformat()


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # nobody is logged in
        return "somebody"


def _document(known: Knowledge, task: str, tree: HypothesisTree, of: TreeOf, noted: Answer | None) -> dict[str, Any]:
    """The first question with all that belongs to it, further ones, lessons, and the answers that hold."""
    asking = open_questions(known, task, tree, of)
    questions = asking.questions()
    taught = lessons_of(asking, questions)
    return {
        "task": task,
        "of": of,
        "noted": None if noted is None else answer_document(noted),
        "compared": compared_document(asking.posterior),
        "clause": str(asking.posterior.best),
        "question": _question(known, questions[0], tree, of) if questions else None,
        "further": [
            {"id": each.id, "text": question_text(each, tree, of), "gain": each.gain} for each in questions[1:]
        ],
        "lessons": [_lesson(each, tree, of) for each in taught],
        "answers": [answer_document(each) for each in _holding(known, task, of)],
        "against_all": [answer_document(each) for each in answers_against_all(known, task, tree, of)],
    }


def _question(known: Knowledge, asked: SetQuestion, tree: HypothesisTree, of: TreeOf) -> dict[str, Any]:
    literal, support = asked.literal, asked.support
    found = sides(known.experience(asked.task, of), literal)
    return {
        "id": asked.id,
        "text": question_text(asked, tree, of),
        "seen": sides_text(found, but=literal.but),
        "literal": {"text": str(literal), "node": literal.node, "values": list(literal.values), "but": literal.but},
        "holds_in": list(found.holds),
        "fails_in": list(found.fails),
        "unknown_in": list(found.unknown),
        "chance": support.chance,
        "gain": asked.gain,
        "answers": [
            {
                "answer": reply.value,
                "meaning": MEANINGS[reply],
                "expected": asked.expected[reply],
                "clause": _clause_after(known, asked, tree, of, reply),
            }
            for reply in FOLDED
        ],
        "answer_schema": answer_schema(asked.id),
    }


def answer_schema(identifier: str) -> dict[str, Any]:
    """JSON Schema of an answer to one question."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "type": "object",
        "properties": {
            "question": {"const": identifier},
            "answer": {"enum": [reply.value for reply in Reply]},
        },
        "required": ["question", "answer"],
        "additionalProperties": False,
    }


def _clause_after(known: Knowledge, asked: SetQuestion, tree: HypothesisTree, of: TreeOf, reply: Reply) -> str | None:
    """What the task would mean after an answer; None where earlier answers leave no room for it."""
    literal = asked.literal
    supposed = Answer(asked.task, literal.node, None, "?", _now(), None, of, literal.values, literal.but, reply)
    try:
        return str(learn_task(known.answer(supposed), asked.task, tree, of).best)
    except KnowledgeError:
        return None


def _lesson(lesson: OtherStart | OtherEnd, tree: HypothesisTree, of: TreeOf) -> dict[str, Any]:
    text = lesson_text(lesson, tree, of)
    if isinstance(lesson, OtherStart):
        return {"kind": "start", "text": text, "node": lesson.node.name, "value": lesson.value, "bits": lesson.bits}
    holds = None if lesson.holds is None else question_id(lesson.holds)
    return {"kind": "contrast", "text": text, "fails": question_id(lesson.fails), "holds": holds, "gain": lesson.gain}


def _holding(known: Knowledge, task: str, of: TreeOf) -> list[Answer]:
    given = [each for each in known.answers if (each.task, each.tree_of) == (task, of)]
    return [*in_force(given).values(), *replies_in_force(given)]


def _print(document: dict[str, Any], count: int) -> None:
    """Print the document of a task with so many demonstrations."""
    if (noted := document["noted"]) is not None:
        console.print(f"noted: {noted['answer'] or 'withdrawn'}   {noted['question']}")
        if noted in document["against_all"]:
            console.print(Text("note ", style="yellow") + Text(f"your answer {against_all(count)}"))
        console.print()
    if document["question"] is not None:
        _print_question(document["question"])
    elif any(document["compared"].values()):
        console.print(Text("nothing left to ask", style="bold") + Text(f": {document['clause']}"))
    else:
        console.print(Text("nothing can be compared yet", style="bold") + Text(": learn another task, then ask again"))
    if document["further"]:
        console.print("then:")
        for each in document["further"][:FURTHER]:
            console.print(Text(f"  {each['text']}"))
    if document["lessons"]:
        console.print("what a demonstration would tell:")
        for each in document["lessons"]:
            console.print(Text(f"  {each['text']}"))


def _print_question(question: dict[str, Any]) -> None:
    console.print(Text(question["text"], style="bold"))
    console.print(question["seen"])
    for each in question["answers"]:
        console.print(Text(f"  {each['answer']:8}{each['meaning']}"))
        if each["clause"] is not None:
            console.print(Text(f"          → {each['clause']}", style="dim"))
    console.print(Text(f"  {Reply.UNKNOWN.value:8}{MEANINGS[Reply.UNKNOWN]}"))
    console.print(Text(f"  id: {question['id']}", style="dim"))


def _print_answers(known: Knowledge, task: str, tree: HypothesisTree, of: TreeOf) -> None:
    holding = _holding(known, task, of)
    for answer in holding:
        console.print(Text(answer_text(answer, tree)))
        console.print(Text(f"  id: {answer.about}", style="dim"))
    if not holding:
        console.print("no answers")
