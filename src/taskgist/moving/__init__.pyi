from .steps import HoldUp as HoldUp
from .steps import PutDown as PutDown
from .steps import Take as Take
from .steps import Wait as Wait
from .steps import Withdraw as Withdraw
