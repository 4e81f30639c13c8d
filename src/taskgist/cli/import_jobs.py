"""The recordings that ``taskgist import`` is to make: one of each file, or of each take of one set-up."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskgist.cli.common import check_target
from taskgist.cli.found import matches
from taskgist.common.files import writing
from taskgist.common.workers import Progress, silent
from taskgist.errors import MappingError
from taskgist.importing.build import import_recording
from taskgist.importing.looking import Proposal, look, mapping_text
from taskgist.importing.mapping_file import load_mapping
from taskgist.importing.tables import input_files
from taskgist.recording.mcap import write
from taskgist.recording.recording import Recording

Tell = Callable[[Proposal, Path], None]
"""Says what a file holds, and where its mapping was written."""


def _nobody(_proposal: Proposal, _mapping: Path) -> None:
    """What nobody hears."""


@dataclass(frozen=True)
class Job:
    """One recording that is to be made.

    Attributes:
        source: A file of motion capture, or a mapping.
        out: The recording.
        parameters: Values of the mapping's parameters.
        data: Folder of its tables, if it is not the mapping's own.
        replace: Whether files that are there are replaced.
        take: What differs from other recordings by the same mapping.
    """

    source: Path
    out: Path
    parameters: Mapping[str, str]
    data: Path | None
    replace: bool
    take: Path | None = None

    @property
    def named(self) -> Path:
        """What people call it by."""
        return self.take or self.source

    def mapping(self, tell: Tell = _nobody) -> Path:
        """The mapping: that which was given, or that of the file, which is written beside the recording.

        Raises:
            MappingError: The file cannot be read, leaves something open, or its mapping is there already.
        """
        if self.source.suffix.lower() == ".toml":
            return self.source
        mapping = self.out.with_suffix(".toml")
        if mapping.exists() and not self.replace:
            hint = f"taskgist import {mapping} -o {self.out}; to write it anew, add --replace"
            raise MappingError("the mapping is there already: import that", where=mapping, hint=hint)
        proposal = look(self.source)
        self._check_out([self.source])
        check_target(mapping, "--out", replace=self.replace, inputs=[self.source])
        text = mapping_text(proposal, os.path.relpath(self.source, mapping.parent))
        with writing(mapping, replace=self.replace, error=MappingError) as stream:
            stream.write(text.encode())
        tell(proposal, mapping)
        if proposal.open:
            hint = f"fill in what {mapping} calls open, then: taskgist import {mapping} -o {self.out}"
            raise MappingError("not imported yet: " + "; ".join(proposal.open), where=self.source, hint=hint)
        return mapping

    def recording(self, mapping: Path, progress: Progress = silent) -> Recording:
        """The recording that a mapping makes, written.

        Raises:
            MappingError: Something cannot be read, be right, or be written.
        """
        loaded = load_mapping(mapping, data_dir=self.data, parameters=self.parameters)
        self._check_out(input_files(loaded))
        recording = import_recording(loaded, progress)
        write(recording, self.out, replace=self.replace)
        return recording

    def document(self) -> dict[str, Any]:
        """What was imported, without a word meanwhile; errors as above."""
        mapping = self.mapping()
        return imported(self.recording(mapping), self.out, mapping)

    def _check_out(self, inputs: Sequence[Path]) -> None:
        check_target(self.out, "--out", replace=self.replace, suffix=".mcap", what="recordings", inputs=inputs)


def imported(recording: Recording, out: Path, mapping: Path) -> dict[str, Any]:
    """What was imported, as a document."""
    return {
        "recording": str(out),
        "mapping": str(mapping),
        "frames": len(recording.times_s),
        "seconds": float(recording.times_s[-1] - recording.times_s[0]),
        "agents": list(recording.scene.agents),
        "objects": list(recording.scene.objects),
        "notes": list(recording.provenance.notes),
        "fit": recording.provenance.as_dict()["fit"],
    }


def parameter(text: str, option: str) -> tuple[str, str]:
    """Name and value of NAME=VALUE.

    Raises:
        MappingError: It is none.
    """
    name, separator, value = text.partition("=")
    if not separator or not name:
        raise MappingError("not a parameter", field=option, value=text, hint="write NAME=VALUE")
    return name, value


def several(
    paths: Sequence[Path],
    each: str | None,
    parameters: Mapping[str, str],
    data: Path | None,
    out: Path | None,
    *,
    replace: bool,
) -> list[Job]:
    """A recording of each file, or of each take that one mapping brings in.

    Args:
        paths: The files.
        each: The parameter that differs, and the pattern of its values: NAME=PATTERN.
        parameters: Values of the mapping's parameters.
        data: Folder of its tables, if it is not the mapping's own.
        out: The folder to write to, which is made; None: this one.
        replace: Whether files that are there are replaced.

    Raises:
        MappingError: Two would have one name; nothing matches; the folder cannot be made.
    """
    takes = _takes(paths, each, data) if each else {path: {} for path in paths}
    folder = _folder(out)
    made: dict[Path, Job] = {}
    for take, own in takes.items():
        job = Job(paths[0] if each else take, folder / f"{take.stem}.mcap", {**parameters, **own}, data, replace, take)
        if job.out in made:
            hint = "import them one by one, or into folders of their own (-o)"
            raise MappingError(f"{made[job.out].named} and {take} would both become it", where=job.out, hint=hint)
        made[job.out] = job
    return list(made.values())


def _takes(paths: Sequence[Path], each: str, data: Path | None) -> dict[Path, dict[str, str]]:
    """Files and folders that match, and what each is for the mapping."""
    name, pattern = parameter(each, "--each")
    if len(paths) > 1 or paths[0].suffix.lower() != ".toml":
        hint = "name one mapping (.toml); several files without --each are imported each by its own"
        raise MappingError("is for one mapping", field="--each", value=each, hint=hint)
    tables = data or paths[0].parent
    found = matches(str(tables / pattern))
    if not found:
        raise MappingError("nothing matches", where=tables, field="--each", value=pattern, hint="check the pattern")
    return {take: {name: Path(os.path.relpath(take, tables)).as_posix()} for take in found}


def _folder(out: Path | None) -> Path:
    if out is None:
        return Path()
    if out.suffix.lower() == ".mcap":
        hint = "name a folder"
        raise MappingError("several recordings do not go into one", field="--out", value=str(out), hint=hint)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        hint = "name a folder"
        raise MappingError(f"cannot be made: {error.strerror}", where=out, field="--out", hint=hint) from error
    return out
