"""Names that older versions of numpy, scipy and Python had, and libraries for drawing.

A submission written for the course's environment of a few years ago should be judged by its
disparities. So names that were pure aliases, or moved, are put back with their old meaning where
this machine's versions lack them (inspecting.py tells the author), and libraries that only draw or
read pictures are replaced where they are not installed by stand-ins: importing them works, using
them is an error.
"""

import builtins
import collections
import collections.abc
import fractions
import functools
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import math
import sys
import time

import numpy

# Without these the machine is at fault and not the submission.
REQUIRED = ("numpy", "scipy")

# Libraries that only draw or read pictures.
DRAWING = ("matplotlib", "pylab", "imageio", "PIL", "mat4py")

# Calls that change nothing but how pictures are shown.
HARMLESS = ("close", "ioff", "ion", "switch_backend", "use")

# What numpy called them before -> what they are. Removed in 1.24 or 2.0.
NUMPY_ALIASES = {
    "bool": "bool",
    "int": "int",
    "float": "float",
    "complex": "complex",
    "object": "object",
    "str": "str",
    "long": "int",
    "unicode": "str",
    "float_": "np.float64",
    "complex_": "np.complex128",
    "Inf": "np.inf",
    "Infinity": "np.inf",
    "infty": "np.inf",
    "PINF": "np.inf",
    "NaN": "np.nan",
    "NAN": "np.nan",
    "bool8": "np.bool_",
    "string_": "np.bytes_",
    "unicode_": "np.str_",
    "int0": "np.intp",
    "uint0": "np.uintp",
    "cfloat": "np.complex128",
    "singlecomplex": "np.complex64",
    "longfloat": "np.longdouble",
    "clongfloat": "np.clongdouble",
    "longcomplex": "np.clongdouble",
    "mat": "np.asmatrix",
    "alltrue": "np.all",
    "sometrue": "np.any",
    "product": "np.prod",
    "cumproduct": "np.cumprod",
    "round_": "np.round",
    "in1d": "np.isin",
    "rank": "np.ndim",
    "row_stack": "np.vstack",
    "trapz": "np.trapezoid",
}

# What has no other name, but is as easily written.
NUMPY_PHRASES = {
    "NINF": ("-np.inf", -numpy.inf),
    "NZERO": ("-0.0", -0.0),
    "PZERO": ("0.0", 0.0),
    "asscalar": ("a.item()", lambda a: a.item()),
    "math": ("math", math),
    "msort": ("np.sort(a, axis=0)", lambda a: numpy.sort(a, axis=0)),
    "asfarray": (
        "np.asarray(a, dtype=float)",
        lambda a, dtype=numpy.float64: numpy.asarray(a, dtype=dtype),
    ),
}

# Windows that moved from scipy.signal to scipy.signal.windows. Removed in 1.13.
WINDOWS = (
    "barthann bartlett blackman blackmanharris bohman boxcar chebwin cosine exponential flattop gaussian "
    "general_cosine general_gaussian general_hamming hamming hann kaiser nuttall parzen taylor triang tukey"
).split()

# Namespaces of scipy.ndimage whose functions all live in scipy.ndimage itself.
NDIMAGE_PARTS = ("filters", "interpolation", "measurements", "morphology", "fourier")


class Missing(Exception):
    """A library that submissions may rely on is not installed here."""

    def __init__(self, name):
        super().__init__(
            "the Python package {0} is not installed where this is graded: install it with "
            "`{1} -m pip install {0}`".format(name, sys.executable)
        )


def absent():
    """Which of the libraries that submissions may rely on are not installed here."""
    return [name for name in REQUIRED if importlib.util.find_spec(name) is None]


def stands_in(module):
    """Whether a library for drawing is not installed here, so that a stand-in takes its place."""
    name = module.split(".")[0]
    return name in DRAWING and importlib.util.find_spec(name) is None


@functools.lru_cache(maxsize=None)
def gone():
    """The names that this machine's numpy lacks, with what they are called now."""
    known = {old: now for old, (now, _) in NUMPY_PHRASES.items()}
    known.update(NUMPY_ALIASES)
    return {old: now for old, now in known.items() if old not in numpy.__dict__}


@functools.lru_cache(maxsize=None)
def gone_windows():
    """The windows that this machine's scipy.signal lacks, with what they are called now."""
    if importlib.util.find_spec("scipy") is None:
        return {}
    signal = importlib.import_module("scipy.signal")
    return {name: "scipy.signal.windows." + name for name in WINDOWS if not hasattr(signal, name)}


def restore():
    """Puts back what is gone, and makes stand-ins for what is not installed."""
    for old, now in gone().items():
        if old in NUMPY_PHRASES:
            value = NUMPY_PHRASES[old][1]
        elif now.startswith("np."):
            value = getattr(numpy, now[3:])
        else:
            value = getattr(builtins, now)
        setattr(numpy, old, value)
    if not hasattr(time, "clock"):
        time.clock = time.process_time
    if not hasattr(fractions, "gcd"):
        fractions.gcd = math.gcd
    for name in collections.abc.__all__:
        if not hasattr(collections, name):
            setattr(collections, name, getattr(collections.abc, name))
    sys.meta_path.insert(0, _Afterwards())
    sys.meta_path.append(_NdimageParts())
    sys.meta_path.append(_StandIns())


def _add_windows(signal):
    windows = importlib.import_module("scipy.signal.windows")
    for name in WINDOWS:
        if not hasattr(signal, name) and hasattr(windows, name):
            setattr(signal, name, getattr(windows, name))


def _draw_nowhere(module):
    """There is no screen: what is to be drawn on is not up to the submission."""
    for name in ("use", "switch_backend"):
        if hasattr(module, name):
            setattr(module, name, lambda *_arguments, **_options: None)


# What is done to modules once they are imported, which takes long.
AFTERWARDS = {
    "matplotlib": _draw_nowhere,
    "matplotlib.pyplot": _draw_nowhere,
    "scipy.signal": _add_windows,
}


class _Afterwards(importlib.abc.MetaPathFinder):
    """Changes modules that are imported, if the submission imports them."""

    def find_spec(self, name, path=None, target=None):
        change = AFTERWARDS.get(name)
        spec = importlib.machinery.PathFinder.find_spec(name, path) if change else None
        if spec is not None and spec.loader is not None:
            load = spec.loader.exec_module

            def exec_module(module):
                load(module)
                change(module)

            spec.loader.exec_module = exec_module
        return spec


class _NdimageParts(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds scipy.ndimage.filters and its like when scipy no longer has them."""

    def find_spec(self, name, path=None, target=None):
        parent, _, part = name.rpartition(".")
        if parent == "scipy.ndimage" and part in NDIMAGE_PARTS:
            return importlib.machinery.ModuleSpec(name, self)
        return None

    def exec_module(self, module):
        ndimage = importlib.import_module("scipy.ndimage")
        names = [name for name in dir(ndimage) if not name.startswith("_")]
        module.__dict__.update({name: getattr(ndimage, name) for name in names})
        module.__all__ = names


class _StandIns(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds libraries for drawing when they are not installed."""

    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in DRAWING:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def exec_module(self, module):
        name = module.__name__
        module.__all__ = []
        module.__getattr__ = lambda attribute: _part(name, attribute)


class _StandIn:
    """Something in a library that is not installed. Calling it is an error."""

    def __init__(self, name):
        self._name = name

    def __getattr__(self, attribute):
        return _part(self._name, attribute)

    def __call__(self, *_arguments, **_options):
        if self._name.rpartition(".")[2] in HARMLESS:
            return
        raise RuntimeError(
            "{} is called, but {} is not installed where this is graded: a graded function has "
            "no need to draw or read pictures; remove the call".format(
                self._name, self._name.split(".")[0]
            )
        )


def _part(name, attribute):
    if attribute.startswith("__"):
        raise AttributeError("{} has no attribute {}".format(name, attribute))
    return _StandIn(name + "." + attribute)
