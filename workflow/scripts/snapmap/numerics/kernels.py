"""What kernels share: fused multiply-adds, a sine, the width of vectors; and how they are compiled.

All give the same bits on every machine. A kernel is kept on disk, in a folder named by a hash of
its sources, so that an edit never meets an older kernel; and numba's files there are sealed.
"""

import fcntl
import hashlib
import time
import warnings
from collections.abc import Callable
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import numpy as np
from numba import float64, njit, types
from numba.core import caching, config, event
from numba.extending import intrinsic
from numba.misc.appdirs import AppDirs

from . import portable

VECTOR_BITS = 512
"""Widest vectors to use where the processor has them."""


@intrinsic
def fma(context, a, b, c):
    """a b + c in one rounding."""

    def build(_, builder, __, arguments):
        return builder.fma(*arguments)

    return float64(float64, float64, float64), build


@intrinsic
def widen_vectors(context):
    """Compile the function that calls this with vectors of VECTOR_BITS, and by itself.

    LLVM stops at 256 bits on some processors that have 512, and the kernel then takes up to twice
    the time. numba's own settings would reach the functions of whoever imports this, too. A loop
    over lanes may lose its vectors where LLVM puts it into its caller.
    """

    def build(context, builder, _, __):
        attribute = f'"prefer-vector-width"="{VECTOR_BITS}"'
        set.add(builder.function.attributes, attribute)  # llvmlite's own `add` knows few of LLVM's
        builder.function.attributes.add("noinline")
        return context.get_dummy_value()

    return types.none(), build


_sine_of_rest = njit(error_model="numpy", inline="always")(portable.sine_of_rest)


@njit(error_model="numpy", inline="always")
def sine(turns):
    """As `portable.sine`, in a form of which the compiler makes vectors."""
    return _sine_of_rest(turns - np.rint(turns))


INLINED = "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper"
"""Options of what is compiled into its callers alone."""


def compiled(function: Callable) -> Callable:
    """Compile a function for the types that it is called with, and keep that on disk.

    No fast maths: NaN stays visible, and a result does not depend on how a call was compiled. What
    speed needs is written out: fused multiply-adds, and sums in an order that vectorises over
    lanes. numba reads where to keep it here, and no other package's functions are moved.
    """
    chosen_by_user = config.CACHE_DIR
    cache_folder = chosen_by_user or AppDirs("snapmap", False).user_cache_dir
    sources = _hash(Path(function.__code__.co_filename).parent)
    config.CACHE_DIR = str(Path(cache_folder, f"kernels_{sources}"))
    # numba hands the options of an inlined caller down unless they are said.
    options = dict.fromkeys(INLINED, False)
    try:
        return njit(nogil=True, cache=True, error_model="numpy", **options)(function)
    finally:
        config.CACHE_DIR = chosen_by_user


def inlined(function: Callable) -> Callable:
    """Compile a function into each of its callers, without which nothing is vectorised.

    Python itself cannot call it: what that takes would be half of its time to compile.
    """
    return njit(error_model="numpy", **dict.fromkeys(INLINED, True))(function)


@cache
def _hash(folder):
    """Hash what the kernels of a folder are compiled from: its modules, and those of this folder.

    numba by itself sees an edit in the file of the function, and none in a file of what it calls.
    """
    paths = sorted({*folder.glob("*.py"), *Path(__file__).parent.glob("*.py")})
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:12]


SEAL = b"SHA-256 of all bytes before: "
"""With its 32 bytes it ends a file of numba's cache: LLVM ends the process over a damaged one."""
_CacheFile = caching.IndexDataCacheFile
_numba_save, _numba_load = _CacheFile.save, _CacheFile.load
_numba_open = _CacheFile._open_for_write
_numba_load_index, _numba_load_data = _CacheFile._load_index, _CacheFile._load_data
PATIENCE = 300
"""Seconds; no kernel takes longer to compile."""
_claims = {}
"""Open files by the kernels that this process compiles, locked until they are saved."""


@contextmanager
def _open_sealed(file, path):
    with _numba_open(file, path) as part:
        yield part
        part.flush()
        part.write(SEAL + hashlib.sha256(Path(part.name).read_bytes()).digest())


def _load_index(file):
    """Read which kernels are kept; none where that is damaged."""
    with suppress(Exception):  # a damaged pickle may raise any
        _require_whole(file._index_path)
        return _numba_load_index(file)
    return {}


def _load_data(file, name):
    """Read a kernel; raises OSError for one that is damaged: numba then compiles it anew."""
    try:
        _require_whole(file._data_path(name))
        return _numba_load_data(file, name)
    except Exception as fault:
        raise OSError(str(fault)) from fault


def _require_whole(path):
    data, mark, digest = Path(path).read_bytes().rpartition(SEAL)
    if mark and hashlib.sha256(data).digest() != digest:
        raise OSError(f"{path}: is damaged")


def _locked(path):
    """Open a file that no other process has locked, or has for longer than PATIENCE."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    file = open(path, "w")  # noqa: SIM115
    for _ in range(10 * PATIENCE):
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(0.1)
            continue
        except OSError:  # some file systems of clusters have no locks
            pass
        break
    return file


def _load_or_claim(file, key):
    """Load a kernel; one that another process compiles is waited for, else this one will do it."""
    kernel, claim = _numba_load(file, key), (file._index_path, key)
    if kernel is None and claim not in _claims:
        name = hashlib.sha256(repr(key).encode()).hexdigest()[:12]
        with suppress(OSError):
            _claims[claim] = _locked(f"{file._index_path}.{name}.lock")
            kernel = _numba_load(file, key)
    if kernel is not None:
        _release(claim)
    return kernel


def _release(claim):
    if claim in _claims:
        _claims.pop(claim).close()


def _save_alone(file, key, data):
    """Add a kernel to numba's cache, if there is room, while no other process does.

    Else both number their kernels alike, and a process calls one in the place of the other.
    """
    with suppress(OSError), _locked(f"{file._index_path}.lock"):
        _numba_save(file, key, data)
    _release((file._index_path, key))


# numba offers no other way in.
_CacheFile.load, _CacheFile.save = _load_or_claim, _save_alone
_CacheFile._open_for_write = _open_sealed
_CacheFile._load_index, _CacheFile._load_data = _load_index, _load_data


class Reporter(event.Listener):
    """Reports once that a kernel of some size is compiled: a user would else wait in silence."""

    depth, reported = 0, frozenset()

    def on_start(self, event: event.Event) -> None:
        """Count a compilation; those within another are a part of it."""
        self.depth += 1
        sizes = {type_.count for type_ in event.data["args"] if isinstance(type_, types.UniTuple)}
        if self.depth == 1:
            for size in sizes - self.reported:
                words = f"compiling the kernel of {size} modes: once, some seconds"
                warnings.warn_explicit(words, UserWarning, "snapmap", 1)
            self.reported |= sizes

    def on_end(self, event: event.Event) -> None:
        """Count the end of a compilation."""
        self.depth -= 1


event.register("numba:compile", Reporter())
