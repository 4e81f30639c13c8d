from .findings import Audit as Audit
from .findings import Finding as Finding
from .findings import MotionLimits as MotionLimits
from .findings import Tolerances as Tolerances
from .outputs import plan_document as plan_document
from .outputs import robot_trajectory as robot_trajectory
from .outputs import write_positions as write_positions
