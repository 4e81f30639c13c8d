from .address import Address as Address
from .address import file_of as file_of
from .address import shown as shown
from .database import check as check
from .database import create as create
from .database import load as load
from .database import save as save
from .database import update as update
