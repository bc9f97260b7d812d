"""What usually lies behind an error, and what to do about it."""

import errno
import re

from hazcam_runner import older

CONFINED = (
    "a submission may read only its own folder, Python and the system's libraries, and write only "
    "to its own folder and to where tempfile writes; it may not start programs or other processes "
    "(multiprocessing; its ThreadPool too, unlike concurrent.futures.ThreadPoolExecutor), open "
    "connections or change permissions"
)

# Exception type, pattern in its text, hint. The first that fits is given.
_ERRORS = (
    ("NameError", r"'xrange'", "xrange is of Python 2: write range"),
    ("NameError", r"'raw_input'|'unicode'|'long'|'reduce'", "that name is of Python 2"),
    (
        "TypeError",
        r"'(numpy\.)?float\d*' object cannot be interpreted as an integer"
        r"|slice indices must be integers",
        "in Python 3 `/` gives a fraction: write `//`, or int(...), for sizes and indices",
    ),
    (
        "IndexError",
        r"only integers, slices",
        "an index must be a whole number: in Python 3 `/` gives a fraction, `//` does not",
    ),
    (
        "IndexError",
        r"out of bounds",
        "every scene has its own size, box and maxd: take sizes from Il.shape, bbox and maxd, and "
        "keep windows, and the pixel d columns to the left, inside of the image; an array is indexed "
        "[row, column], which is [y, x]",
    ),
    (
        "ValueError",
        r"could not be broadcast together",
        "at the edges of the image a slice is shorter than in the middle",
    ),
    (
        "ValueError",
        r"assignment destination is read-only",
        "work on a copy: np.array(x)",
    ),
    (
        "AttributeError",
        r"module 'numpy' has no attribute",
        "this machine's numpy no longer has that name; numpy's release notes say what replaced it",
    ),
    (
        "AttributeError",
        r"module 'scipy[\w.]*' has no attribute",
        "this machine's scipy no longer has that name, or its part must be imported first "
        "(import scipy.ndimage)",
    ),
    (
        "ImportError",
        r"cannot import name .* from 'scipy",
        "this machine's scipy no longer has that name (or has moved it); filters are in "
        "scipy.ndimage, windows in scipy.signal.windows",
    ),
    (
        "ImportError",
        r"attempted relative import",
        "a submission is a folder and no package: write `from common import name`, without the dot",
    ),
    (
        "RuntimeError",
        r"can't start new thread",
        "a submission gets one processor and a few threads: do without",
    ),
    ("URLError", r"", "a submission may not open connections: hand in what is needed"),
    (
        "RecursionError",
        r"",
        "the function calls itself too deeply: write it as a loop",
    ),
    ("SystemExit", r"", "a graded function must return and not end the program: remove exit()"),
    (
        "EOFError",
        r"",
        "nobody sits at the keyboard while this is graded: remove input()",
    ),
    (
        "TypeError",
        r"stereo_disparity_(fast|best)\(\) "
        r"(takes \d+ positional arguments? but 4 were given|missing \d+ required positional argument)",
        "the function is called with four arguments: Il, Ir, bbox, maxd",
    ),
    (
        "MemoryError",
        r"",
        "the arrays are larger than the limit of memory: work row by row or one disparity at a "
        "time, and in float32",
    ),
)

_OS_ERRORS = {
    errno.EACCES: CONFINED,
    errno.EPERM: CONFINED,
    errno.ENOSYS: CONFINED,
    errno.EFBIG: "the file is larger than a submission may write",
    errno.EMFILE: "too many files are open at a time: close them",
    errno.ENOENT: "files are looked for in the submission's folder: hand in what is needed there",
}


def for_error(error, text):
    """A hint for an error whose type and text are `text`, or None."""
    if isinstance(error, ModuleNotFoundError):
        library, _, part = (error.name or "").partition(".")
        if part and library in older.REQUIRED:
            return (
                "this machine's {0} has no such part (any more); {0}'s release notes say what "
                "replaced it".format(library)
            )
        return (
            "this module is neither in the submission nor installed where this is graded: hand "
            "the file in, or remove the import"
        )
    if isinstance(error, OSError) and error.errno in _OS_ERRORS:
        return _OS_ERRORS[error.errno]
    names = {each.__name__ for each in type(error).__mro__}
    for name, pattern, hint in _ERRORS:
        if name in names and re.search(pattern, text):
            return hint
    return None


def for_syntax(error):
    """A hint for an error in the grammar, or None."""
    line = (error.text or "").strip()
    message = error.msg or ""
    if isinstance(error, TabError) or "inconsistent use of tabs" in message:
        return (
            "tabs and spaces are mixed: let the editor turn all tabs into four spaces "
            "(convert indentation to spaces)"
        )
    if isinstance(error, IndentationError):
        if "\t" in (error.text or ""):
            return "this line is indented with a tab, others with spaces: use spaces everywhere"
        return "lines of one block must begin in the same column"
    if re.match(r"print\b(?!\s*\()", line) or "Missing parentheses in call to 'print'" in message:
        return "this is Python 2: write print(...)"
    if re.match(r"except\b[^(]*,", line) or "exception types" in message:
        return "this is Python 2: write `except Error as name:`"
    if line.startswith(("%", "!")):
        return "this line belongs to a notebook: remove it"
    if re.search(r"<>|`|\bexec\s+['\"]|\braise\s+\w+\s*,", line):
        return "this is Python 2; it is run by Python 3"
    if "leading zeros" in message:
        return "write whole numbers without leading zeros"
    if "unterminated" in message or "never closed" in message or "EOF" in message:
        return "a bracket or quotation mark is opened and never closed, perhaps lines above"
    if "non-UTF-8" in message or "utf-8" in message or "null bytes" in message:
        return "save the file as UTF-8"
    return None
