from .rendering import Rendered as Rendered
from .rendering import looking as looking
from .rendering import pinhole as pinhole
from .rendering import render as render
from .rendering import save_figure as save_figure
from .scene import before_after_picture as before_after_picture
from .scene import see_picture as see_picture
