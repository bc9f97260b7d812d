"""Importing the submission's modules."""

import importlib
import os
import sys

from hazcam_runner import arrays, older


class Unusable(Exception):
    """The submission lacks what is needed; the text says what."""


def function(folder, name):
    """The function `name` of the module `name` in the submission's folder."""
    module = load(folder, name)
    found = getattr(module, name, None)
    if found is None:
        others = [each for each in vars(module) if each.startswith("stereo")]
        also = "; it has {}".format(", ".join(others)) if others else ""
        raise Unusable("{0}.py has no function {0}{1}".format(name, also))
    if not callable(found):
        raise Unusable(
            "{0} in {0}.py is {1} and no function: write `def {0}(...):`".format(
                name, arrays.kind(found)
            )
        )
    return found


def load(folder, name):
    """Imports the module `name` from the submission's folder."""
    os.chdir(folder)
    if sys.path[0] != folder:
        sys.path[0] = folder
    # Asked before: what the submission says of itself must not be the machine's fault.
    absent = older.absent()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name in absent:
            raise older.Missing(error.name) from error
        raise
