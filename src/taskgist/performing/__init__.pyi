from .findings import Audit as Audit
from .findings import Finding as Finding
from .findings import MotionLimits as MotionLimits
from .findings import Tolerances as Tolerances
from .settling import Settled as Settled
from .settling import settled as settled
