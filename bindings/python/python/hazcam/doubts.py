"""Warnings that show the line of the program that called, however deep in hazcam they come from."""

from __future__ import annotations

import sys
import warnings
from types import FrameType

from .errors import HazcamWarning


def warn(text: str) -> None:
    """Issues a HazcamWarning about the line that called into this package."""
    level = 1
    frame: FrameType | None = sys._getframe()
    while frame is not None and frame.f_globals.get("__name__", "").startswith(f"{__package__}."):
        frame = frame.f_back
        level += 1
    # This function's own frame is the first level.
    warnings.warn(text, HazcamWarning, stacklevel=level)
