"""Reads a mapping file: every section once, in the order of ``docs/import.md``."""

from __future__ import annotations

from collections.abc import Collection
from collections.abc import Mapping as AnyMapping
from pathlib import Path

from taskgist.errors import InputError, UnknownNameError
from taskgist.recording.label import Label
from taskgist.recording.mapping.document import read_document
from taskgist.recording.mapping.model import Mapping, Person, SignalColumn, Support, Thing, Timeline
from taskgist.recording.mapping.people import read_person
from taskgist.recording.mapping.section import Section
from taskgist.recording.mapping.sources import read_source
from taskgist.recording.mapping.things import read_support, read_thing
from taskgist.recording.provenance import Provenance

_SECTIONS = ("about", "time", "sources", "people", "objects", "supports", "signals", "label")


def load_mapping(
    path: str | Path,
    *,
    data_dir: str | Path | None = None,
    parameters: AnyMapping[str, str] | None = None,
) -> Mapping:
    """Read a mapping file; the tables that it names are not opened yet.

    Args:
        path: The TOML file.
        data_dir: Folder at which its relative file names start; default: the folder of the mapping.
        parameters: Values of its [parameters].

    Raises:
        MappingError: The file is missing or no TOML; a field is missing, unknown or out of range.
        UnknownNameError: A source, landmark, part or parameter that does not exist.
        LabelError: The label contradicts itself.
    """
    file = Path(path)
    base = file.parent if data_dir is None else Path(data_dir)
    document, text = read_document(file, parameters or {})
    top = Section(document, file)
    top.only(_SECTIONS)
    sources = {name: read_source(name, section) for name, section in top.sections("sources").items()}
    about = top.section("about")
    people = {name: read_person(name, section, sources) for name, section in top.sections("people").items()}
    things = {name: read_thing(name, section, sources, base) for name, section in top.sections("objects").items()}
    mapping = Mapping(
        name=about.text("name", file.stem),
        file=file,
        data_dir=base,
        about=_about(about, text),
        timeline=_timeline(top.section("time")),
        sources=tuple(sources.values()),
        people=tuple(people.values()),
        objects=tuple(things.values()),
        supports=tuple(read_support(name, section) for name, section in top.sections("supports").items()),
        signals=tuple(_signal(name, section, sources) for name, section in top.sections("signals").items()),
        label=_label(top.section("label"), people, things) if "label" in top else None,
    )
    _check_whole(top, mapping.people, mapping.objects, mapping.supports)
    return mapping


def _about(section: Section, text: str) -> Provenance:
    notes = section.any("notes", [])
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        raise section.error("must be a list of texts", "notes", notes)
    about = Provenance(
        source=section.text("source", ""),
        licence=section.text("licence", ""),
        citation=section.text("citation", ""),
        simulated=section.flag("simulated", False),
        notes=tuple(notes),
        mapping=text,
    )
    section.done()
    return about


def _timeline(section: Section) -> Timeline:
    timeline = Timeline(
        rate_hz=section.number("rate_hz", 30.0, least=1.0, most=1000.0),
        max_gap_s=section.number("max_gap_s", 0.2, least=0.0),
        start_s=section.number("start_s", None),
        end_s=section.number("end_s", None),
    )
    section.done()
    if timeline.start_s is not None and timeline.end_s is not None and timeline.end_s <= timeline.start_s:
        raise section.error("ends before it starts", "end_s", timeline.end_s, "give a time after start_s")
    return timeline


def _signal(name: str, section: Section, sources: Collection[str]) -> SignalColumn:
    source = section.text("source")
    if source not in sources:
        raise UnknownNameError("source", str(source), sources, where=f"{section.file}: {section.path}.source")
    column = section.any("column")
    if isinstance(column, bool) or not isinstance(column, str | int):
        raise section.error("must be a column's name, or its index from 0", "column", column)
    signal = SignalColumn(name, source, column, section.number("scale", 1.0), section.text("unit", ""))
    section.done()
    return signal


def _label(section: Section, people: Collection[str], objects: Collection[str]) -> Label:
    try:
        label = Label(
            task=section.any("task"),
            performing_agent=section.any("performing_agent"),
            target_agent=section.any("target_agent"),
            target_object=section.any("target_object"),
            start_s=section.any("start_s"),
            end_s=section.any("end_s"),
            how=section.text("how", "set in the mapping file"),
        )
        label.check(agents=people, objects=objects)
    except InputError as problem:
        problem.where = problem.where or f"{section.file}: label"
        raise
    section.done()
    return label


def _check_whole(
    top: Section, people: tuple[Person, ...], things: tuple[Thing, ...], supports: tuple[Support, ...]
) -> None:
    if not people and not things:
        raise top.error("the mapping brings in nobody and nothing", hint="add [people.NAME] and [objects.NAME]")
    names = [*(p.name for p in people), *(t.name for t in things), *(s.name for s in supports)]
    for name in names:
        if names.count(name) > 1:
            raise top.error("two of people, objects and supports have the same name", value=name)
        if not name.replace("_", "").replace("-", "").isalnum():
            raise top.error("a name must consist of letters, digits, - and _", value=name)
