"""Errors in words that their author can act on, with the line they come from."""

import os
import traceback

from hazcam_runner import arrays, hints, loading

# The innermost frames tell the most.
FRAMES = 4


def explain(error, folder):
    """(kind, text): the kind is RE, ML or BAD; of the traceback only the submission's frames."""
    if isinstance(error, arrays.BadAnswer):
        return "BAD", str(error)
    if isinstance(error, loading.Unusable):
        return "RE", str(error)
    if isinstance(error, SyntaxError):
        return "RE", _syntax(error, folder)
    kind = "ML" if isinstance(error, MemoryError) else "RE"
    lines = _frames(error, folder)
    text = _in_words(error)
    # Where the submission lies while it is graded is no help.
    text = text.replace(os.path.join(folder, ""), "")
    lines.append(text)
    hint = hints.for_error(error, text)
    if hint:
        lines.append("hint: " + hint)
    return kind, "\n".join(lines)


def _in_words(error):
    """Its type, and what it says if it can be asked."""
    try:
        said = str(error)
    except Exception:
        said = ""
    return "{}: {}".format(type(error).__name__, said) if said else type(error).__name__


def _frames(error, folder):
    lines = []
    found = traceback.extract_tb(error.__traceback__)
    for frame in [each for each in found if _within(each.filename, folder)][-FRAMES:]:
        where = "{}, line {}".format(os.path.relpath(frame.filename, folder), frame.lineno)
        lines.append(where if frame.name == "<module>" else "{}, in {}".format(where, frame.name))
        if frame.line:
            lines.append("    " + frame.line)
    return lines


def _within(path, folder):
    # Frames of the import machinery are called <frozen ...>.
    return not path.startswith("<") and os.path.abspath(path).startswith(os.path.join(folder, ""))


def _syntax(error, folder):
    name = error.filename
    line, text = syntax_parts(error)
    if name is None:
        # Of a file that is no text at all Python tells no name: who imported it does.
        return "\n".join(_frames(error, folder) + [text])
    if _within(name, folder):
        name = os.path.relpath(name, folder)
    return finding_text(name, line, text)


def syntax_parts(error):
    """(line, text) of an error in the grammar: what Python says, the line, what lies behind it."""
    lines = ["{}: {}".format(type(error).__name__, error.msg)]
    if error.text and error.text.strip():
        lines.append("    " + error.text.strip("\r\n").replace("\t", "<tab>").strip())
    hint = hints.for_syntax(error)
    if hint:
        lines.append("hint: " + hint)
    return error.lineno, "\n".join(lines)


def finding_text(name, line, text):
    """A finding in one text."""
    return "{}, line {}: {}".format(name, line, text) if line else "{}: {}".format(name, text)
