"""From here on this process becomes no other program.

Whoever replaces itself by a matcher that happens to be installed hands in somebody else's work. The sandbox cannot
forbid it before Python has started, for it is by `execve` that Python starts; so the runner forbids it to itself, with
one more layer of Landlock, before it reads any file of the submission.

Code that may be read may still be loaded (`ctypes`, `mmap`): what is installed where it may be read is in reach. Files
without a name, which Landlock does not look at, cannot be made or executed: the sandbox refuses `memfd_create`, and
`execveat` is not on its list.
"""

import ctypes
import os

# Numbers of system calls, the same on all processors that hazcam knows, and the right to execute a file.
_CREATE_RULESET, _RESTRICT_SELF = 444, 446
_EXECUTE = ctypes.c_uint64(1 << 0)


def forbid():
    """Forbids it for good, to this thread and to all that it starts. OSError where the kernel does not take it."""
    system = ctypes.CDLL(None, use_errno=True).syscall
    system.restype = ctypes.c_long

    def call(number, *arguments):
        answer = system(ctypes.c_long(number), *arguments)
        if answer < 0:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))
        return answer

    # A right that a layer handles and grants nowhere is gone everywhere.
    size, flags = ctypes.c_size_t(ctypes.sizeof(_EXECUTE)), ctypes.c_long(0)
    ruleset = call(_CREATE_RULESET, ctypes.byref(_EXECUTE), size, flags)
    try:
        call(_RESTRICT_SELF, ctypes.c_long(ruleset), flags)
    finally:
        os.close(ruleset)
