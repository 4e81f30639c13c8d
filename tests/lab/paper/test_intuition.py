"""Table 4 on the values of the paper's study."""

import itertools

import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.learning import Experience, understand
from taskgist_lab.paper.published import COLUMNS, INTUITION, NEEDED, NEEDED_BY_COLUMN, understood
from tests.learning.learning_samples import STUDY, study


def reached(task: str, columns: tuple[str, ...] = COLUMNS) -> int:
    """Demonstrations from which on these columns are understood to the end."""
    held = [
        all(understood(understand(study(task, count)))[column] for column in columns)
        for count in range(1, len(STUDY[task]) + 1)
    ]
    return len(held) - len(list(itertools.takewhile(bool, reversed(held)))) + 1


def test_every_task_has_a_row_and_every_cell_its_nodes() -> None:
    assert set(INTUITION) == set(STUDY) == set(NEEDED)
    names = {node.name for node in STANDARD_TREE.nodes}
    for row in INTUITION.values():
        assert tuple(row) == COLUMNS
        for cell in row.values():
            assert names >= {node for node, _ in cell.kept} | set(cell.pruned)
            for node, value in cell.kept:
                assert value in STANDARD_TREE.node(node).values


@pytest.mark.parametrize("task", STUDY)
def test_demonstrations_needed_are_the_papers(task: str) -> None:
    assert reached(task) == NEEDED[task]
    assert {column: reached(task, (column,)) for column in NEEDED_BY_COLUMN[task]} == NEEDED_BY_COLUMN[task]


@pytest.mark.parametrize("task", STUDY)
def test_nothing_is_understood_of_another_task(task: str) -> None:
    for other in STUDY.keys() - {task}:
        understanding = understand(study(other))
        assert not all(cell.holds(understanding) for cell in INTUITION[task].values())


def test_what_must_be_kept_is_not_without_demonstrations() -> None:
    nothing = understood(understand(Experience("hide")))
    assert nothing == {"see": False, "reach": True, "object": False}
