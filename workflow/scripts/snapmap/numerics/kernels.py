"""What all kernels share: a fused multiply-add, a sine, wide vectors, and how they are compiled.

Kernels give the same bits on every machine. They are kept on disk, in a folder named by a hash of
their sources and numba's version, so that an edited kernel never meets an older one, nor one of
another numba, and all clones share those of the same sources; each file there ends with a hash.
"""

import fcntl
import hashlib
import logging
import os
import time
from collections.abc import Callable
from contextlib import chdir, contextmanager, suppress
from functools import cache
from pathlib import Path

import numpy as np

try:
    with chdir("/"):  # a folder may have a .numba_config.yaml, of whoever made it
        import numba
except ValueError as fault:
    names = ", ".join(f"{key}={os.environ[key]}" for key in os.environ if key.startswith("NUMBA_"))
    raise ValueError(f"{names}: {fault}; unset it") from None
from numba import float64, njit, types
from numba.core import caching, config, event
from numba.extending import intrinsic
from numba.misc.appdirs import AppDirs

from . import portable

config._config_fname = ""  # which numba would look for again whenever it compiles

logger = logging.getLogger("snapmap")
VECTOR_BITS = 512
"""Width of the vectors that kernels use if the processor has them."""


@intrinsic
def fma(context, a, b, c):
    """Return a b + c, rounded once."""

    def build(_, builder, __, arguments):
        return builder.fma(*arguments)

    return float64(float64, float64, float64), build


@intrinsic
def widen_vectors(context):
    """Compile the function that calls this with vectors of VECTOR_BITS, and never into its callers.

    LLVM stops at 256 bits on some processors that have 512, and the kernel then takes up to twice
    the time. numba's own setting would also change the functions of whoever imports snapmap. A loop
    over lanes may lose its vectors if LLVM moves it into a caller.
    """

    def build(context, builder, _, __):
        attribute = f'"prefer-vector-width"="{VECTOR_BITS}"'
        set.add(builder.function.attributes, attribute)  # llvmlite's own `add` knows few of LLVM's
        builder.function.attributes.add("noinline")
        return context.get_dummy_value()

    return types.none(), build


_sine_of_rest = njit(error_model="numpy", inline="always")(portable.sine_of_rest)


@njit(error_model="numpy", inline="always")
def sine(turns: float) -> float:
    """Return sin(2 pi turns), as `portable.sine` does, in a form that the compiler vectorises."""
    return _sine_of_rest(turns - np.rint(turns))


INLINED = "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper"
"""Options of a function that is compiled into its callers only."""
OF_KERNELS = {"error_model": "numpy"} | dict.fromkeys(INLINED, True)
inlined: Callable[[Callable], Callable] = njit(**OF_KERNELS)
"""Compile a function into each of its callers; only so its loops over lanes are vectorised."""
called: Callable[[Callable], Callable] = njit(**OF_KERNELS | {"forceinline": False})
"""Compile a function once for the kernels that call it. As with `inlined`, Python cannot: the
wrapper for that would take half of the time to compile."""


def compiled(function: Callable) -> Callable:
    """Compile a function for each type of its arguments, and keep the kernels on disk.

    Fast maths is off: NaN stays visible, and a result does not depend on how a call was compiled.
    What speed needs is written out: fused multiply-adds, and sums in an order that vectorises over
    lanes. numba reads its cache folder here alone, so other packages keep theirs.
    """
    if config.DISABLE_JIT:
        raise ValueError("NUMBA_DISABLE_JIT: is set, but kernels need numba's compiler; unset it")
    chosen_by_user = config.CACHE_DIR
    cache_folder = chosen_by_user or AppDirs("snapmap", False).user_cache_dir
    sources = _hash(Path(function.__code__.co_filename).parent)
    config.CACHE_DIR = folder = str(Path(cache_folder, f"kernels_{sources}"))
    try:
        # Unless these are named, numba hands down those of an inlined caller.
        options = OF_KERNELS | dict.fromkeys(INLINED, False)
        kernel = njit(nogil=True, cache=True, **options)(function)
    finally:
        config.CACHE_DIR = chosen_by_user
    # numba's own file would be of one clone: its folder is named by the path of the source.
    kept = kernel._cache
    kept._cache_file = _CacheFile(folder, kept._impl.filename_base, sources)
    return kernel


@cache
def _hash(folder):
    """Hash numba's version and the modules of a folder and of this one: its kernels' sources.

    numba itself notices an edit in the file of a kernel, but none in the files that it calls; and
    two versions of numba would each empty the other's list of kernels, one by one.
    """
    paths = sorted({*folder.glob("*.py"), *Path(__file__).parent.glob("*.py")})
    parts = [numba.__version__.encode(), *(path.read_bytes() for path in paths)]
    return hashlib.sha256(b"".join(parts)).hexdigest()[:12]


SEAL = b"SHA-256 of all bytes before: "
"""This and 32 bytes of hash end each file of numba's cache: a damaged file makes LLVM abort."""
PATIENCE = 300
"""Seconds to wait for another process that compiles a kernel; none takes longer."""
_claims = {}
"""Locked files by the kernels that this process compiles; each is open until its kernel is kept."""


class _CacheFile(caching.IndexDataCacheFile):
    """A list of kernels and these, whole or absent; each is compiled by a single process."""

    def load(self, key):
        """Load a kernel, perhaps once another process has compiled it; or claim it for this one."""
        kernel, claim = super().load(key), (self._index_path, key)
        if kernel is None and claim not in _claims:
            name = hashlib.sha256(repr(key).encode()).hexdigest()[:12]
            with suppress(OSError):
                _claims[claim] = _locked(f"{self._index_path}.{name}.lock")
                kernel = super().load(key)
        if kernel is not None:
            _release(claim)
        return kernel

    def save(self, key, data):
        """Add a kernel to the list, if the disk has room, while no other process adds one.

        Two processes at once would give two kernels the same number, and one would be called as
        both.
        """
        with suppress(OSError), _locked(f"{self._index_path}.lock"):
            super().save(key, data)
        _release((self._index_path, key))

    @contextmanager
    def _open_for_write(self, path):
        with super()._open_for_write(path) as part:
            yield part
            part.flush()
            part.write(SEAL + hashlib.sha256(Path(part.name).read_bytes()).digest())

    def _load_index(self):
        """Read the list of the kernels on disk; a damaged one counts as empty."""
        with suppress(Exception):  # a damaged pickle may raise anything
            _require_whole(self._index_path)
            return super()._load_index()
        return {}

    def _load_data(self, name):
        """Read a kernel; raises OSError if it is damaged, and numba then compiles it anew."""
        try:
            _require_whole(self._data_path(name))
            return super()._load_data(name)
        except Exception as fault:
            raise OSError(str(fault)) from fault


def _require_whole(path):
    data, mark, digest = Path(path).read_bytes().rpartition(SEAL)
    if mark and hashlib.sha256(data).digest() != digest:
        raise OSError(f"{path}: is damaged")


def _locked(path):
    """Open a file and lock it; after PATIENCE, or on a file system without locks, only open it."""
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


def _release(claim):
    if claim in _claims:
        _claims.pop(claim).close()


class Reporter(event.Listener):
    """Logs, once for each number of modes, that a kernel is compiled and the user has to wait."""

    depth, reported = 0, frozenset()

    def on_start(self, event: event.Event) -> None:
        """Enter a compilation; log it if it is not part of another."""
        self.depth += 1
        sizes = {type_.count for type_ in event.data["args"] if isinstance(type_, types.UniTuple)}
        if self.depth == 1:
            for size in sizes - self.reported:
                # A warning may be an error, which numba would not survive.
                logger.warning("compiling the kernel of %d modes: once, some seconds", size)
            self.reported |= sizes

    def on_end(self, event: event.Event) -> None:
        """Leave a compilation."""
        self.depth -= 1


event.register("numba:compile", Reporter())
