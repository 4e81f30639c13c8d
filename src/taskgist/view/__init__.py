"""View: pictures of what agents see and of what a demonstration changed."""

from taskgist.view.eyes import before_after_picture, see_picture
from taskgist.view.rendering import Rendered, looking, pinhole, render
from taskgist.view.saving import save_figure

__all__ = ["Rendered", "before_after_picture", "looking", "pinhole", "render", "save_figure", "see_picture"]
