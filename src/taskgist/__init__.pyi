from .errors import TaskgistError as TaskgistError
from .facts.predicates import Predicate as Predicate
from .importing.build import import_recording as import_recording
from .importing.mapping_file import load_mapping as load_mapping
from .language.sentences import meaning as meaning
from .language.sentences import why as why
from .learning.knowledge import Knowledge as Knowledge
from .maps.ability_map import ability_map as ability_map
from .maps.grid import Grid as Grid
from .maps.places import places_for as places_for
from .observe.observer import Observer as Observer
from .perspective.image import visibility as visibility
from .perspective.queries import objects_where as objects_where
from .perspective.queries import parse_question as parse_question
from .perspective.scene_efforts import SceneEfforts as SceneEfforts
from .perspective.search import least_effort as least_effort
from .pipeline.checkup import check as check_recording
from .pipeline.explain import explain_recording as explain_recording
from .pipeline.explain import learn as learn
from .recognition.label_proposal import propose_label as propose_label
from .recording.mcap import read as read_recording
from .recording.mcap import write as write_recording
from .recording.recording import Label as Label
from .recording.recording import Recording as Recording
from .settings import Settings as Settings
from .store.database import load as load_knowledge
from .store.database import update as update_knowledge
from .world.bodies.profile import AgentProfile as AgentProfile
from .world.scene import Scene as Scene
from .world.stage import Stage as Stage

__all__ = [
    "AgentProfile",
    "Grid",
    "Knowledge",
    "Label",
    "Observer",
    "Predicate",
    "Recording",
    "Scene",
    "SceneEfforts",
    "Settings",
    "Stage",
    "TaskgistError",
    "ability_map",
    "check_recording",
    "explain_recording",
    "import_recording",
    "learn",
    "least_effort",
    "load_knowledge",
    "load_mapping",
    "meaning",
    "objects_where",
    "parse_question",
    "places_for",
    "propose_label",
    "read_recording",
    "update_knowledge",
    "visibility",
    "why",
    "write_recording",
]
