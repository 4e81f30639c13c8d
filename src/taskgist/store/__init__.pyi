from .database import Address as Address
from .database import file_of as file_of
from .database import load as load
from .database import save as save
from .database import update as update
