"""CN2 rule induction of Orange, in a process of its own.

Orange is licensed under the GPL. taskgist neither imports nor ships it: ``cn2_process`` is run as a program of its
own, if the user has installed Orange, and the two exchange lines of JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import util

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import InputError
from taskgist.study.evaluation.coded import Codes
from taskgist.study.evaluation.peers.peer import absent

PROGRAM = "taskgist.study.evaluation.peers.cn2_process"


class Cn2:
    """Orange's CN2 with its defaults.

    Raises:
        InputError: Orange is not installed.
    """

    name = "CN2"
    text = "Orange's CN2 rules, one task against the others, its defaults"

    def __init__(self) -> None:
        if util.find_spec("Orange") is None:
            raise absent("Orange", self.name)
        self._process = subprocess.Popen(
            [sys.executable, "-m", PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> NDArray[np.bool_]:
        """Learn and judge; without negatives everything is of the one class that it knows."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        job = {"positives": positives.tolist(), "negatives": negatives.tolist(), "tests": tests.tolist()}
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        if not answer:
            hint = "what it wrote above says why; leave it out, or mend the installation of Orange"
            raise InputError("the process of CN2 ended", field="peer", value=self.name, hint=hint)
        return np.array(json.loads(answer), dtype=bool)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()
