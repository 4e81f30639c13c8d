from .mcap import read as read
from .mcap import relabel as relabel
from .mcap import write as write
from .recording import Label as Label
from .recording import Provenance as Provenance
from .recording import Recording as Recording
from .signals import Signal as Signal
