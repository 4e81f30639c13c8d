"""MJCF documents, with all that they name, as what MuJoCo may read without opening a file.

Includes are put in, and every file that a document names is looked up by whoever has the files: a folder on disk, or
the bundle of a recording, in which case nothing outside of it is ever opened. MuJoCo is given the text and the files.
"""

from __future__ import annotations

import math
import posixpath
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from xml.etree.ElementTree import Element

import mujoco

from taskgist.common.files import is_file, read_whole
from taskgist.errors import SceneError, most_read
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.foreign import MODELS
from taskgist.world.bodies.markup import Marked, asking_mujoco, check_values, located, parse_markup, written
from taskgist.world.bodies.meshes import check_mesh, image_pixels, keep_file, readable_mesh

Read = Callable[[Sequence[str], str], tuple[str, bytes]]
"""Gives the first of several files that is there, by paths relative to the model: its path and content.

The text is the element and attribute that name it, for messages.
"""


def from_folder(folder: Path, where: str | Path, *, limits: Limits = DEFAULT.limits) -> Read:
    """Files on disk, as a user's own scene names them.

    Args:
        folder: The folder of the model.
        where: The model's file, for messages.
        limits: The largest file.
    """

    def read(names: Sequence[str], named_by: str) -> tuple[str, bytes]:
        for name in names:
            path = folder / name
            if is_file(path) or name == names[-1]:
                break
        hint = f"named by {where}: {named_by}"
        return name, read_whole(path, most_bytes=limits.mesh_bytes, setting="mesh_bytes", error=SceneError, hint=hint)

    return read


def from_files(files: Mapping[str, bytes], where: str | Path) -> Read:
    """Files of a bundle, and nothing else, whatever a stranger's model names."""

    def read(names: Sequence[str], named_by: str) -> tuple[str, bytes]:
        for name in names:
            if name in files:
                return name, files[name]
        hint = "a scene in a recording holds all its files, and nothing outside of it is opened"
        raise SceneError(
            "names a file that is not among the scene's own", where=where, field=named_by, value=names[0], hint=hint
        )

    return read


def read_mjcf(
    root: Marked,
    read: Read,
    files: dict[str, bytes],
    *,
    where: str,
    prefix: str = "",
    limits: Limits = DEFAULT.limits,
) -> mujoco.MjSpec:
    """A document as a MuJoCo specification.

    Args:
        root: The document; changed.
        read: Gives the files that it names.
        files: The bundle, to which they are added by names without folders.
        where: File for error messages.
        prefix: Put before the names of its files.
        limits: Bounds of what it may ask for.

    Raises:
        SceneError: It is no model, names a file that cannot be read, or asks for too much.
    """
    gathered = _Gathered(read, files, where, prefix, limits)
    text = _text(root, gathered)
    assets = {name: files[name] for name in gathered.names.values()}
    return _spec(text, gathered.models, assets, root.comment, where, limits)


def read_kept(data: bytes, *, where: str, limits: Limits = DEFAULT.limits) -> mujoco.MjSpec | None:
    """As ``read_mjcf``, of a document that names no file: the same bodies come into many scenes. None of any other.

    Raises:
        SceneError: MuJoCo cannot read it.
    """
    kept = _sound(data, limits) if len(data) <= KEPT_BYTES else None
    return _spec(kept[0], {}, {}, kept[1], where, limits) if kept else None


KEPT_BYTES = 100_000
"""Documents up to this length are kept."""


@lru_cache(maxsize=64)
def _sound(data: bytes, limits: Limits) -> tuple[str, str] | None:
    """Text and comment of a document that names no file and has no fault; None of any other."""
    try:
        root = parse_markup(data, where="", limits=limits)
        return _text(root, _Gathered(from_files({}, ""), {}, "", "", limits)), root.comment
    except SceneError:
        return None


def _text(root: Marked, gathered: _Gathered) -> str:
    """The text of a document, checked, with what it names gathered."""
    if root.tag != "mujoco":
        raise SceneError("not a model", where=gathered.where, field=root.tag, hint=MODELS)
    text = gathered.document(root, "", ())
    if gathered.pixels > gathered.limits.hfield_pixels:
        hint = most_read(gathered.limits.hfield_pixels, "hfield_pixels")
        pixels = f"{gathered.pixels:,} pixels"
        raise SceneError("height fields too large", where=gathered.where, value=pixels, hint=hint)
    return text


def _spec(
    text: str,
    models: Mapping[str, bytes],
    assets: Mapping[str, bytes],
    comment: str,
    where: str,
    limits: Limits,
) -> mujoco.MjSpec:
    with asking_mujoco("MuJoCo cannot read this model:", where):
        spec = mujoco.MjSpec.from_string(text, include=models, assets=assets)
    check_bodies(len(spec.bodies), where, limits)  # deformable things have one for every vertex of their file
    spec.comment = comment
    return spec


FOLDERS = ("meshdir", "texturedir", "assetdir", "strippath")
MOST_ATTACHED = 10
NAMED_BY_FILE = ("mesh", "hfield")
"""Elements that are called after their file where nothing else is said."""


@dataclass
class _Gathered:
    """The documents and files of a model, as far as they were found.

    Attributes:
        files: The bundle.
        names: Meshes, height fields and the like of this model: their names in the bundle, by path.
        converted: Paths of those that are of another kind there.
        models: Documents of models that are attached, by names without folders.
        pixels: Of all height fields together.
    """

    read: Read
    files: dict[str, bytes]
    where: str
    prefix: str
    limits: Limits
    names: dict[str, str] = field(default_factory=dict)
    converted: set[str] = field(default_factory=set)
    models: dict[str, bytes] = field(default_factory=dict)
    pixels: int = 0
    _attached: dict[str, str] = field(default_factory=dict)
    _sizes: dict[str, tuple[int, int]] = field(default_factory=dict)

    def document(self, root: Marked, folder: str, trail: tuple[str, ...]) -> str:
        """The text of a document that names nothing but ``files`` and ``models``; these are added.

        Args:
            root: The document; changed.
            folder: Where it lies, relative to the whole model.
            trail: The documents that led to it.
        """
        origins = self._include(root, folder)
        _drop_looks(root)
        check_values(root, where=self.where)
        for element in root.iter():
            for key, pixels in _asked(element):
                self._check_asked(element, key, pixels)
        dirs = _directories(root)
        for element in list(root.iter()):
            if element.tag == "model":
                self._model(element, folder, trail)
            elif element.tag != "compiler":
                for key in [key for key in element.attrib if key.startswith("file")]:
                    self._file(element, key, folder, origins.get(element, folder), dirs)
        self._check_count(root, trail)
        return written(root)

    def _include(self, root: Marked, folder: str) -> dict[Element, str]:
        """Put included documents in the place of what includes them, each once.

        Returns:
            The folder of every element that was included.
        """
        origins: dict[Element, str] = {}
        seen: set[str] = set()
        rest: list[Element] = [root]
        while rest:
            parent = rest.pop()
            while (index := next((i for i, each in enumerate(parent) if each.tag == "include"), None)) is not None:
                element = parent[index]
                origin = origins.get(element, folder)
                names = [_joined(at, element.get("file", "")) for at in dict.fromkeys((folder, origin))]
                name, data = self.read(names, f"file of {element!r}")
                if name in seen:
                    raise located(element, "file", "is included twice", name, self.where, "include it once")
                seen.add(name)
                inner = parse_markup(data, where=name, limits=self.limits)
                for each in inner.iter():
                    assert isinstance(each, Marked)
                    origins[each], each.line = posixpath.dirname(name), 0
                self._check_few(len(origins))
                parent[index : index + 1] = list(inner)
            rest += parent
        return origins

    def _model(self, element: Element, folder: str, trail: tuple[str, ...]) -> None:
        """A model that is attached becomes a document of its own."""
        if "file" not in element.attrib:
            return
        name, data = self.read([_joined(folder, element.get("file", ""))], f"file of {element!r}")
        if name in trail or len(trail) >= MOST_ATTACHED:
            hint = f"at most {MOST_ATTACHED} are read, each attached to the next"
            raise located(element, "file", "a model that attaches itself, or too many others", name, self.where, hint)
        if name not in self._attached:
            child = parse_markup(data, where=name, limits=self.limits)
            text = self.document(child, posixpath.dirname(name), (*trail, name)).encode()
            self._attached[name] = keep_file(self.models, name.replace("/", "_"), text)
        element.set("file", self._attached[name])

    def _file(self, element: Element, key: str, folder: str, origin: str, dirs: _Directories) -> None:
        given = element.get(key, "").replace("\\", "/")
        if not given:
            return
        given = posixpath.basename(given) if dirs.strip else given
        names = [_joined(posixpath.join(at, dirs.meshes), given) for at in dict.fromkeys((folder, origin))]
        name, data = self.read(names, f"{key} of {element!r}")
        if name not in self.names:
            kind, ending = element.get("content_type", ""), ""
            if element.tag == "mesh":
                data, ending = readable_mesh(data, name, where=self.where, kind=kind, limits=self.limits)
            elif element.tag == "flexcomp":
                check_mesh(data, name, where=self.where, kind=kind, limits=self.limits)
            elif element.tag == "hfield":
                self.pixels += image_pixels(data)
            self.names[name] = keep_file(self.files, self.prefix + given.replace("/", "_") + ending, data)
            if ending:
                self.converted.add(name)
        if name in self.converted:
            element.attrib.pop("content_type", None)
        element.set(key, self.names[name])
        if element.tag in NAMED_BY_FILE and key == "file" and not element.get("name"):
            element.set("name", posixpath.splitext(posixpath.basename(given))[0])

    def _check_asked(self, element: Element, key: str, asked: float) -> None:
        bound = self.limits.arena_bytes if key == "memory" else self.limits.array_length
        setting = "arena_bytes" if key == "memory" else "array_length"
        if element.tag == "hfield":
            bound, setting = self.limits.hfield_pixels, "hfield_pixels"
            self.pixels += int(min(asked, bound))
        if not asked <= bound:
            hint = f"at most {bound:,} (setting limits.{setting})"
            raise located(element, key, "asks for too much memory", element.get(key), self.where, hint)

    def _check_count(self, root: Marked, trail: tuple[str, ...]) -> None:
        """Refuse what becomes too many elements when it is repeated and attached."""
        elements = bodies = 0.0
        rest: list[tuple[Element, float]] = [(root, 1.0)]
        while rest:
            element, times = rest.pop()
            times *= _copies(element)
            attached = self._sizes.values() if element.tag == "attach" else ()
            elements += times * (1 + sum(size for size, _ in attached))
            bodies += times * ((element.tag in ("body", "flexcomp")) + sum(size for _, size in attached))
            rest += ((each, times) for each in element)
        self._check_few(elements)
        check_bodies(bodies, self.where, self.limits)
        self._sizes[trail[-1] if trail else ""] = (int(elements), int(bodies))

    def _check_few(self, count: float) -> None:
        if not count <= self.limits.model_elements:
            hint = most_read(self.limits.model_elements, "model_elements")
            raise SceneError("too many elements", where=self.where, value=f"{count:,.0f}", hint=hint)


def check_bodies(count: float, where: str | Path, limits: Limits) -> None:
    """Refuse a model of too many bodies.

    Raises:
        SceneError: It is one.
    """
    if not count <= limits.model_bodies:
        hint = most_read(limits.model_bodies, "model_bodies")
        raise SceneError("too many bodies", where=where, value=f"{count:,.0f}", hint=hint)


@dataclass(frozen=True)
class _Directories:
    """Where a document looks for its files."""

    meshes: str
    strip: bool


def _directories(root: Element) -> _Directories:
    """What the document's ``<compiler>`` elements say, which is taken out of them: the last one counts."""
    said: dict[str, str] = {}
    for compiler in root.iter("compiler"):
        for key in FOLDERS:
            if key in compiler.attrib:
                said[key] = compiler.attrib.pop(key).replace("\\", "/")
    meshes = said.get("meshdir", said.get("assetdir", ""))
    return _Directories(meshes, said.get("strippath", "").lower() == "true")


def _drop_looks(root: Element) -> None:
    """Take out images, what shows them, and skins: nothing here looks at them, and they may be missing, or large."""
    for parent in list(root.iter()):
        parent.attrib.pop("texture", None)
        for each in list(parent):
            if each.tag in ("texture", "layer", "skin") or each.get("objtype") == "texture":
                parent.remove(each)


def _joined(folder: str, name: str) -> str:
    """A path relative to a folder, without detours."""
    return posixpath.normpath(posixpath.join(folder, name.replace("\\", "/"))) if name else name


# --- What a document asks MuJoCo to make room for.

SHAPED = {"hfield": ("nrow", "ncol"), "camera": ("resolution",)}
LENGTHS = frozenset({"nsample", "njmax", "nconmax", "nstack", "nuserdata", "nkey"})
UNITS = {"K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40, "P": 2**50, "E": 2**60}


def _asked(element: Element) -> Iterator[tuple[str, float]]:
    """Attributes of an element that make MuJoCo allocate, and how much."""
    keys = SHAPED.get(element.tag, ())
    present = [key for key in keys if key in element.attrib]
    if present:
        yield present[0], math.prod(_product(element.get(key, "")) for key in present)
    for key in element.attrib:
        if key in LENGTHS:
            yield key, _product(element.get(key, ""))
        elif key.startswith("nuser_"):  # so many for every element, of which there may be thousands
            yield key, 1000 * _product(element.get(key, ""))
    if element.tag == "mesh" and "params" in element.attrib:  # steps along two directions, for meshes that are made
        steps = max(map(_product, element.get("params", "").split()), default=0.0)
        yield "params", steps**2
    if element.tag == "numeric" and "size" in element.attrib:
        yield "size", _product(element.get("size", ""))
    if element.tag == "user" and "dim" in element.attrib:
        yield "dim", _product(element.get("dim", ""))
    if element.tag == "size" and "memory" in element.attrib:
        memory = element.get("memory", "").strip()
        yield "memory", _product(memory.rstrip("KMGTPEkmgtpe")) * UNITS.get(memory[-1:].upper(), 1)


def _product(text: str) -> float:
    """Product of the numbers of an attribute; 0 for what is none, which MuJoCo refuses itself."""
    try:
        return math.prod(abs(float(token)) for token in text.split())
    except ValueError:
        return 0.0


def _copies(element: Element) -> float:
    """How many there will be of what an element holds, as MuJoCo has it where nothing is said."""
    if element.tag in ("replicate", "composite"):
        return max(1.0, _product(element.get("count", "1")))
    if element.tag != "flexcomp" or element.get("type") in ("mesh", "gmsh", "direct"):
        return 1.0
    if element.get("dof") in FEW:
        return FEW[element.get("dof", "")]
    return max(1.0, _product(element.get("count", "10 10 10")))


FEW = {"trilinear": 8.0, "quadratic": 27.0}
"""Bodies of deformable things that bend in few ways, however many vertices they have."""
