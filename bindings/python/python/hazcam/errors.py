"""What goes wrong, grouped by who must act.

Every message says what it is about, what it was given, what is allowed, and the remedy.
"""


class HazcamError(Exception):
    """Whatever hazcam raises. By itself: it could not work, and not for what it was given."""


class ArgumentError(HazcamError, ValueError):
    """An argument has a value that is not allowed, or arguments do not fit each other."""


class ArgumentTypeError(HazcamError, TypeError):
    """An argument is of the wrong kind: no array, samples of another type, no whole number."""


class FrameMemoryError(HazcamError, MemoryError):
    """A frame needs more memory than is allowed or there is; nothing was taken."""


class FileAccessError(HazcamError, OSError):
    """A file cannot be read or written. Nothing half-written is left behind.

    ``filename`` is the file, ``errno`` the system's number, ``None`` where there is none.
    """

    def __str__(self) -> str:
        # Python's own would put number and file around a message that names the file.
        return super().__str__() if self.strerror is None else self.strerror


class MissingFileError(FileAccessError, FileNotFoundError):
    """There is no such file, or no folder to write it to."""


class FileContentError(HazcamError, ValueError):
    """A file is damaged, too large, or holds something else than is needed."""


class HazcamWarning(UserWarning):
    """Something had to be assumed, or looks like a mistake."""
