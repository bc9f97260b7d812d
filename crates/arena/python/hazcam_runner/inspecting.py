"""What can be seen in a submission without running its matchers.

A finding says in which file and line something is, in words, and whether it is fatal: whether the
tests of that module need not be run. Whether the files exist is checked before Python is started.
"""

import ast
import collections
import collections.abc
import fractions
import os
import time
import unicodedata

from hazcam_runner import arrays, explaining, loading, older

MODULES = ("stereo_disparity_fast", "stereo_disparity_best")
IDENTIFIER = "secret_id"
# Packages that bring matchers of their own.
MATCHERS = {"cv2": "StereoBM and StereoSGBM", "hazcam": "fast, balanced and best"}
SHORTEST, LONGEST = 4, 32


def inspect(folder):
    """(secret ID or None, findings)."""
    findings = []
    modules = [name + ".py" for name in MODULES]
    for path in [each for each in modules if os.path.isfile(os.path.join(folder, each))]:
        findings += [_finding(path[: -len(".py")], *each) for each in _look(folder, path)]
    for name in older.REQUIRED + older.DRAWING:
        if os.path.isfile(os.path.join(folder, name + ".py")):
            text = "it hides the library of that name: call your file otherwise"
            findings.append(_finding(name, None, text, False))
    for path in _others(folder):
        findings += [_finding(path[: -len(".py")], *each) for each in _look(folder, path)]
    identifier = None
    if os.path.isfile(os.path.join(folder, IDENTIFIER + ".py")):
        identifier, text = _identify(folder)
        if text:
            findings.append(_finding(IDENTIFIER, None, text, False))
    return identifier, findings


def _finding(name, line, text, fatal, doubtful=False):
    return {
        "file": name + ".py",
        "line": line,
        "text": text,
        "fatal": fatal,
        # For whoever grades: it may not be all its author's work.
        "doubtful": doubtful,
    }


def _others(folder):
    """The other files of Python, relative to the folder, in order."""
    found = []
    for root, _, names in os.walk(folder):
        for name in names:
            path = os.path.relpath(os.path.join(root, name), folder)
            if name.endswith(".py") and path[: -len(".py")] not in MODULES:
                found.append(path)
    return sorted(found)


def _look(folder, path):
    """(line, text, fatal) for what is wrong in one of the two modules, or in a file that they may import, where nothing
    is fatal: whoever imports it hears of it."""
    name = path[: -len(".py")]
    is_module = name in MODULES
    with open(os.path.join(folder, path), "rb") as file:
        source = file.read()
    if is_module and source.lstrip().startswith(b"{") and b'"cells"' in source:
        text = (
            "it is a notebook: export it as Python (jupyter nbconvert --to script, "
            "or File > Save as .py)"
        )
        yield None, text, True
        return
    try:
        tree = ast.parse(source, path)
        if is_module:
            compile(source, path, "exec", dont_inherit=True)
    except SyntaxError as error:
        yield (*explaining.syntax_parts(error), is_module)
        return
    except ValueError as error:
        yield None, "it is no Python source: {}; save it as UTF-8".format(error), is_module
        return
    except (MemoryError, RecursionError) as error:
        if is_module:
            text = (
                "{}: Python cannot read it, because an expression or a block is nested too deeply"
            )
            yield None, text.format(type(error).__name__), True
        return
    if is_module:
        yield from _signature(tree, name)
    yield from _advice(tree, folder)


def _advice(tree, folder):
    advice = [*_stand_ins(tree), *_matchers(tree, folder), *_older_names(tree), *_small_types(tree)]
    return sorted(advice, key=lambda each: each[0])


def _signature(tree, name):
    found = [each for each in tree.body if isinstance(each, ast.FunctionDef) and each.name == name]
    if not found:
        if not _may_come_from_elsewhere(tree, name):
            others = [each.name for each in tree.body if isinstance(each, ast.FunctionDef)]
            also = " (it defines {})".format(", ".join(others[:5])) if others else ""
            text = "there is no function {}(Il, Ir, bbox, maxd){}".format(name, also)
            yield None, text, True
        return
    function = found[-1]
    arguments = function.args
    count = len(getattr(arguments, "posonlyargs", [])) + len(arguments.args)
    least = count - len(arguments.defaults)
    needed = [d for d in arguments.kw_defaults if d is None]
    if least > 4 or (count < 4 and arguments.vararg is None) or needed:
        text = (
            "{} takes {} arguments, but it is called with four: Il, Ir, bbox, maxd".format(
                name, count
            )
        )
        # What is called may be something else than what is written here.
        changed = function.decorator_list or _may_come_from_elsewhere(tree, name, function)
        yield function.lineno, text, not changed


def _may_come_from_elsewhere(tree, name, known=None):
    """Whether the name is imported, assigned, or may come with `import *` or without being written."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            if any((each.asname or each.name) in (name, "*") for each in node.names):
                return True
        if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Store):
            return True
        if isinstance(node, ast.Name) and node.id in ("globals", "setattr", "exec", "vars"):
            return True
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name == name:
            if node is not known:
                return True
    return False


def _imports(tree):
    """(line, package) where one is imported first."""
    seen = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module]
        else:
            continue
        for name in (each.split(".")[0] for each in names):
            if name not in seen:
                seen.add(name)
                yield node.lineno, name


def _stand_ins(tree):
    for line, name in _imports(tree):
        if older.stands_in(name):
            text = (
                "{} is not installed where this is graded; importing it is fine, using it is "
                "an error".format(name)
            )
            yield line, text, False


def _matchers(tree, folder):
    for line, name in _imports(tree):
        own = os.path.join(folder, name)
        if name in MATCHERS and not os.path.isdir(own) and not os.path.isfile(own + ".py"):
            text = "{} brings matchers ({}): they would not be its author's work".format(
                name, MATCHERS[name]
            )
            yield line, text, False, True


def _older_names(tree):
    seen = set()
    for line, module, name in _names(tree):
        now = _now(module.rpartition(".")[2], name)
        whole = "{}.{}".format(module, name)
        if now and whole not in seen:
            seen.add(whole)
            text = "{} is gone; it is run as {}, which you should write".format(whole, now)
            yield line, text, False


def _names(tree):
    """(line, module, name) of what is taken from modules, by a point or by an import."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            module = _dotted(node.value)
            if module:
                yield node.lineno, module, node.attr
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for each in node.names:
                yield node.lineno, node.module, each.name


def _dotted(node):
    """The text of names with points between them, or None."""
    if isinstance(node, ast.Name):
        return node.id
    before = _dotted(node.value) if isinstance(node, ast.Attribute) else None
    return before and "{}.{}".format(before, node.attr)


def _now(module, name):
    """What a name is called today that its module lacks; None if it has it, or never had."""
    if (module, name) == ("time", "clock") and not hasattr(time, name):
        return "time.process_time"
    if (module, name) == ("fractions", "gcd") and not hasattr(fractions, name):
        return "math.gcd"
    if module == "collections" and name in collections.abc.__all__:
        return None if hasattr(collections, name) else "collections.abc." + name
    if module in ("np", "numpy"):
        return older.gone().get(name)
    if module == "signal" and name in older.WINDOWS:
        return older.gone_windows().get(name)
    return None


def _small_types(tree):
    """Types in which differences of grey values would wrap around.

    Whether anything is calculated in them is not known from the source alone, so what is said is
    when it matters: a result may well be kept in them.
    """
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        turned = node.args if getattr(node.func, "attr", None) == "astype" else []
        for given in turned + [each.value for each in node.keywords if each.arg == "dtype"]:
            name = getattr(given, "attr", None) or getattr(given, "value", None)
            if name in ("uint8", "int8"):
                text = (
                    "if sums or differences are taken in {0}, they wrap around (in uint8, 3 - 5 is "
                    "254 and 200 + 100 is 44): leave grey values float32 then, as the images come; "
                    "whole numbers up to {1} that are only kept may be {0}".format(
                        name, {"uint8": 255, "int8": 127}[name]
                    )
                )
                yield node.lineno, text, False
                return


def _identify(folder):
    """(secret ID, None), or (None, what is wrong)."""
    older.restore()
    try:
        identifier = loading.function(folder, IDENTIFIER)()
    except BaseException as error:
        return None, explaining.explain(error, folder)[1]
    # Of a class made from it the protocol would not know what it is.
    if type(identifier) is not str:
        return None, "secret_id() returned {}, but a string (str) is needed".format(
            arrays.kind(identifier)
        )
    unseen = next((i for i, each in enumerate(identifier) if not each.isprintable()), None)
    if not SHORTEST <= len(identifier) <= LONGEST or unseen is not None:
        which = ""
        if unseen is not None:
            which = "; character {}, U+{:04X}, is not printable".format(
                unseen + 1, ord(identifier[unseen])
            )
        return None, (
            "secret_id() returned {!r} ({} characters), but {} to {} printable characters are "
            "needed{}".format(identifier[:40], len(identifier), SHORTEST, LONGEST, which)
        )
    # The same rule as `is_secret_id`, which takes no other: it must not be dropped without a word.
    if identifier != identifier.strip():
        return None, (
            "secret_id() returned {!r}, which begins or ends with a space: {} to {} printable "
            "characters are needed, with no space at an end".format(identifier, SHORTEST, LONGEST)
        )
    if _looks_otherwise(identifier):
        return None, (
            "secret_id() returned {}, which would not look on the board as it is: no character may "
            "be blank but plain spaces between words, a letter may have at most two accents, and "
            "= + - @ cannot come first".format(ascii(identifier))
        )
    return identifier, None


# Letters and signs without a picture.
_BLANK = "\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0"


def _looks_otherwise(identifier):
    """The rest of the rule of `is_secret_id`."""
    marks = 2  # No accent comes first: there it would have no letter.
    for character in identifier:
        # Mn, Mc and Me are marks on the letter before.
        marks = marks + 1 if unicodedata.category(character)[0] == "M" else 0
        if marks > 2 or character in _BLANK or "\ufe00" <= character <= "\ufe0f":
            return True
        if "\U000e0000" <= character <= "\U000e01ef" or "\u180b" <= character <= "\u180f":
            return True
    return identifier[0] in "=+-@"
