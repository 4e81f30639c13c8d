from .label_proposal import Grip as Grip
from .label_proposal import grips_of as grips_of
from .label_proposal import propose_label as propose_label
