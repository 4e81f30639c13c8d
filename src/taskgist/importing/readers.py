"""The formats of motion capture that are read, how each is told by its first bytes, and what other files are.

A reader is a file in ``formats`` that turns one published format into a ``Take``. A file is known by what it holds, not
by its name: many programs write ``.csv``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from taskgist.common.array_files import ArrayFile
from taskgist.common.files import is_file, reading, shown_path
from taskgist.common.text import MOST_SHOWN
from taskgist.errors import InputError, MappingError
from taskgist.importing.formats.bvh import is_bvh, read_bvh
from taskgist.importing.formats.c3d import is_c3d, read_c3d
from taskgist.importing.formats.keypoints import is_mediapipe, is_zed, read_mediapipe, read_zed
from taskgist.importing.formats.motive import is_motive, read_motive
from taskgist.importing.formats.nexus import is_nexus, read_nexus
from taskgist.importing.formats.qualisys import is_qualisys, read_qualisys
from taskgist.importing.formats.ros import METADATA, is_ros, read_ros
from taskgist.importing.formats.smplx import JOINTS, PARAMETERS, read_smplx
from taskgist.importing.formats.trc import is_trc, read_trc
from taskgist.importing.mat import BEGINNING, VERSION_7_3, MatFile
from taskgist.importing.takes import Take
from taskgist.settings import DEFAULT

ARCHIVE = b"PK\x03\x04"
"""How an NPZ begins."""
HEAD_BYTES = 8192
"""What is looked at of a file to tell its format."""


@dataclass(frozen=True)
class Reader:
    """One format.

    Attributes:
        title: What people call it.
        known: Whether a file that begins with these bytes is of this format.
        read: The take of a file: path, how messages name it, and the bytes that it may take.
        arrays: Names of arrays of which an NPZ of this format has one.
        oriented: Whether it may hold orientations.
        suffix: The end of its files' names, where no other format has it.
        up: The axis that points up by the format's custom, for files that do not say.
    """

    title: str
    known: Callable[[bytes], bool]
    read: Callable[[Path, str, int], Take]
    arrays: frozenset[str] = frozenset()
    oriented: bool = False
    suffix: str = ""
    up: str | None = None


def _no(head: bytes) -> bool:  # noqa: ARG001 - told by its arrays
    return False


READERS: Mapping[str, Reader] = {
    "c3d": Reader("C3D", is_c3d, read_c3d, suffix=".c3d"),
    "trc": Reader("TRC (OpenSim, Motion Analysis)", is_trc, read_trc, suffix=".trc", up="y"),
    "bvh": Reader("BVH", is_bvh, read_bvh, oriented=True, suffix=".bvh", up="y"),
    "motive": Reader("CSV of OptiTrack Motive", is_motive, read_motive, oriented=True, up="y"),
    "nexus": Reader("CSV of Vicon Nexus or Tracker", is_nexus, read_nexus, oriented=True, up="z"),
    "qualisys": Reader("TSV of Qualisys Track Manager", is_qualisys, read_qualisys, oriented=True, up="z"),
    "zed": Reader("JSON of ZED bodies", is_zed, read_zed),
    "mediapipe": Reader("JSON of MediaPipe poses", is_mediapipe, read_mediapipe, up="-y"),
    "ros": Reader("bag of ROS 1 or ROS 2", is_ros, read_ros, oriented=True, suffix=".bag", up="z"),
    "smplx": Reader("NPZ of SMPL, SMPL-X or AMASS", _no, read_smplx, arrays=PARAMETERS | {*JOINTS}, oriented=True),
}
"""By the name that a mapping gives as ``format``."""

SUFFIXES = {reader.suffix: name for name, reader in READERS.items() if reader.suffix}

_BLENDER = "convert it to BVH: in Blender, File > Import > FBX, then File > Export > Motion Capture (.bvh)"
CONVERSIONS: Mapping[str, str] = {
    ".fbx": f"FBX is a closed format: {_BLENDER}",
    ".glb": "a scene of glTF: import it in Blender and export the skeleton as BVH",
    ".gltf": "a scene of glTF: import it in Blender and export the skeleton as BVH",
    ".blend": "a Blender file: export the skeleton as BVH, File > Export > Motion Capture (.bvh)",
    ".amc": "motion of Acclaim, whose skeleton stands in an ASF file: convert the pair to BVH (amc2bvh) or C3D",
    ".asf": "a skeleton of Acclaim, whose motion stands in AMC files: convert the pair to BVH (amc2bvh) or C3D",
    ".qtm": "a project file of Qualisys: in QTM, File > Export > To TSV (with header) or To C3D",
    ".tak": "a take of OptiTrack: in Motive, File > Export Tracking Data as CSV (with header) or C3D",
    ".ttp": "a project of OptiTrack: in Motive, export each take as CSV (with header) or C3D",
    ".vsk": "a subject of Vicon, which holds no motion: export the trial from Nexus as C3D or CSV",
    ".vst": "a template of a Vicon subject, which holds no motion: export the trial from Nexus as C3D or CSV",
    ".x1d": "raw data of Vicon cameras: reconstruct and label it in Nexus, then export it as C3D or CSV",
    ".x2d": "raw data of Vicon cameras: reconstruct and label it in Nexus, then export it as C3D or CSV",
    ".mvn": "a recording of Xsens: in MVN, File > Export as C3D or BVH",
    ".mvnx": "XML of Xsens: in MVN, File > Export as C3D or BVH",
    ".svo": "a video of a ZED camera: run body tracking on it and save the bodies as JSON",
    ".svo2": "a video of a ZED camera: run body tracking on it and save the bodies as JSON",
    ".mkv": "a video: track the people in it first, and save their points as JSON, CSV or NPZ",
    ".mp4": "a video: track the people in it first, and save their points as JSON, CSV or NPZ",
    ".avi": "a video: track the people in it first, and save their points as JSON, CSV or NPZ",
    ".mot": "joint angles of OpenSim: give the markers (.trc) instead",
    ".sto": "results of OpenSim: give the markers (.trc) instead",
    ".osim": "a model of OpenSim, which holds no motion: give the markers (.trc)",
    ".pkl": "a pickle runs code when it is opened: save its arrays with numpy.savez",
    ".pickle": "a pickle runs code when it is opened: save its arrays with numpy.savez",
    ".pt": "tensors of PyTorch: save them with numpy.savez",
    ".h5": "HDF5: save its arrays with numpy.savez; in MATLAB, save(..., '-v7') writes a file that is read",
    ".hdf5": "HDF5: save its arrays with numpy.savez",
    ".parquet": "a table of Parquet: save it as CSV, pandas.read_parquet(...).to_csv(...)",
    ".xlsx": "a workbook of Excel: save the sheet as CSV",
    ".xls": "a workbook of Excel: save the sheet as CSV",
    ".ods": "a workbook: save the sheet as CSV",
    ".json": "JSON of a kind that is not known: read are bodies of ZED and world landmarks of MediaPipe; of OpenPose, "
    "whose points are places in the image, triangulate several cameras to TRC (Pose2Sim), or save points as CSV",
    ".zip": "an archive: unpack it",
    ".gz": "packed: unpack it",
}
"""What other files are and how to convert them, by the ends of their names."""

_BEGINNINGS: Mapping[bytes, str] = {
    b"Kaydara FBX": ".fbx",
    b"; FBX": ".fbx",
    b"glTF": ".glb",
    VERSION_7_3: ".h5",
    BEGINNING: ".mat",
    b"\x89HDF": ".h5",
    b"PAR1": ".parquet",
    b":ASF": ".asf",
    b"\x1f\x8b": ".gz",
}
"""How such files begin, whatever their names."""
_TABLES = {".csv": "text", ".tsv": "text", ".txt": "text", ".npz": "arrays", ".npy": "arrays", ".mat": "arrays"}


def read_take(path: Path, kind: str, *, where: str = "", most_bytes: int = DEFAULT.limits.table_bytes) -> Take:
    """The take of a file.

    Args:
        path: The file.
        kind: Its format, a key of ``READERS``.
        where: How messages name it; by default its path.
        most_bytes: How large it may be.

    Raises:
        MappingError: It cannot be read, is too large, not of this format, or empty.
    """
    take = READERS[kind].read(path, where or shown_path(path), most_bytes)
    if not take.tracks or not all(len(track.times_s) for track in take.tracks.values()):
        raise MappingError("holds no frames", where=where or shown_path(path), hint="export the take again")
    return take


def kind_of(path: Path) -> str:
    """The format of a file, a key of ``READERS``.

    Raises:
        MappingError: It cannot be read, is a table without a known layout, or of a format that is not read; the message
            says which, and how to convert it.
    """
    if is_file(path / METADATA):
        return "ros"
    with reading(path, error=MappingError) as stream:
        head = stream.read(HEAD_BYTES)
    names = _arrays(path) if head.startswith(ARCHIVE) and path.suffix.lower() == ".npz" else frozenset()
    found = next((kind for kind, reader in READERS.items() if reader.known(head) or reader.arrays & names), None)
    if found is None:
        raise _foreign(path, head)
    return found


def _arrays(path: Path) -> frozenset[str]:
    most_bytes = DEFAULT.limits.table_bytes
    return frozenset(ArrayFile(path, most_bytes=most_bytes, where=shown_path(path), error=MappingError).names)


def _held(path: Path, suffix: str) -> str | None:
    """The arrays of a file, with their shapes; nothing of texts."""
    if _TABLES[suffix] == "text":
        return None
    most_bytes, where = DEFAULT.limits.table_bytes, shown_path(path)
    file: MatFile | ArrayFile = (
        MatFile(path, most_bytes=most_bytes, where=where)
        if suffix == ".mat"
        else ArrayFile(path, most_bytes=most_bytes, where=where, error=MappingError)
    )
    shown = []
    for name in file.names[:MOST_SHOWN]:
        with suppress(InputError):  # what cannot be read is told where it is asked for
            shown.append(f"{name} {'x'.join(map(str, file.array(name).shape))}")
    return ", ".join(shown) + (", ..." if len(file.names) > MOST_SHOWN else "")


def _foreign(path: Path, head: bytes) -> MappingError:
    suffix = next((end for start, end in _BEGINNINGS.items() if head.startswith(start)), path.suffix.lower())
    where = shown_path(path)
    if not head:
        return MappingError("the file is empty", where=where, hint="check the path")
    if suffix in CONVERSIONS:
        return MappingError("cannot be imported as it is", where=where, hint=CONVERSIONS[suffix])
    if suffix in SUFFIXES:
        title = READERS[SUFFIXES[suffix]].title
        return MappingError(f"is no {title}, though its name says so", where=where, hint="export it again")
    if suffix in _TABLES:
        hint = "write a mapping that says what its columns are: see docs/howto/import.md"
        problem = f"a table of {_TABLES[suffix]} whose layout is not known"
        return MappingError(problem, where=where, value=_held(path, suffix), hint=hint)
    titles = ", ".join(reader.title for reader in READERS.values())
    hint = f"export it as one of these: {titles}; or write a mapping of tables: see docs/howto/import.md"
    return MappingError("of a kind that is not known", where=where, hint=hint)
