"""Machine code of kernels, cached between runs and loaded without numba.

Reading numba's own cache requires `import numba`, which takes longer than most commands. Therefore,
the object file that LLVM produces for a kernel is cached, and later processes link it with llvmlite
alone. The code is identical, so the results are bitwise equal.

A file is identified by everything that determines its code: the instructions and constants of the
kernel and of the functions it calls, the signature, the versions of numba and llvmlite, and the
processor. Outdated code is therefore never used after an edit, an update or a change of machine,
and a checksum detects truncated files. All external symbols of the code must exist in this process
before the code is linked, because LLVM terminates the process if a symbol is missing. If this is
not certain, the file of the kernel is empty and numba runs the kernel. This concerns kernels that
allocate memory, which requires numba's runtime, and kernels with argument types that `Signature`
does not support. It also concerns all kernels on systems other than Linux, which are untested.

The program contains code for the processors of a baseline (`BASELINES`), which is used until a
kernel has been compiled for this processor. This code does not depend on the version of numba that
is installed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import shutil
import struct
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small_text, read_whole_file
from vomstudio.core.files.user_folders import state_folder
from vomstudio.core.paths import resource, user_cache
from vomstudio.geometry.kernels.signatures import Signature
from vomstudio.geometry.kernels.sources import (
    KernelPart,
    KernelSource,
    all_code_objects,
    link_parts,
)

_FILE_SIGNATURE = b"vomstudio kernel 1\n"
_DIGEST_BYTES = 16
MAX_VERSIONS = 8
NUMBA_SYMBOLS = ("NRT_", "numba_", "Py", "_Py")
_HEADER_FORMAT = struct.Struct("<H")
_ENGINES: list[Any] = []
"""Engines of the loaded kernels; the code is freed together with its engine."""


class Baseline(NamedTuple):
    """Processors for which the program contains compiled kernels.

    `cpu` and `features` are LLVM names.
    """

    cpu: str
    features: tuple[str, ...]


BASELINES = {
    "x86_64": Baseline(
        "x86-64-v3", ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
    ),
    "aarch64": Baseline("generic", ()),
}
"""Baselines by architecture (System V ABI, *AMD64 Architecture Processor Supplement*, 3.1.1)."""
INCLUDED_FOLDER = f"{sys.implementation.cache_tag}-{sys.platform}-{platform.machine()}"
"""Folder of the included code in ``resources/kernels``. The names of its files depend on the
instructions of Python, which differ between versions."""


class _UncacheableKernelError(Exception):
    """Raised if the code cannot be cached, so that numba must run the kernel."""


def entry(
    source: KernelSource, compile_with_numba: Callable[[], Callable[..., Any]]
) -> Callable[..., Any] | None:
    """Return the kernel as machine code.

    It is compiled if neither the cache nor the program contains code for this processor.

    Parameters
    ----------
    source : KernelSource
    compile_with_numba : callable
        Function that returns the kernel compiled by numba, which reports errors raised inside the
        code.

    Returns
    -------
    callable or None
        The kernel, or None if numba must compile it.
    """
    if not _can_link_code():
        return None
    try:
        signature = Signature(source.signature)
        code = load_code(_file_name(source))
        if code is None:
            code = _included_code(source)
        if code is None:
            code = _compile_and_store(source)
        return _link_code(signature, code, compile_with_numba)
    except (_UncacheableKernelError, ValueError):
        return None


def compile_for_this_processor(source: KernelSource) -> bool:
    """Compile a kernel for this processor and cache it, unless the cache contains it.

    Parameters
    ----------
    source : KernelSource

    Returns
    -------
    bool
        Whether the cache contains the kernel; otherwise, numba must compile it.
    """
    if not _can_link_code():
        return False
    try:
        code = load_code(_file_name(source))
        return bool(_compile_and_store(source) if code is None else code)
    except (_UncacheableKernelError, ValueError):
        return False


def _can_link_code() -> bool:
    return sys.platform == "linux" and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


def _compile_and_store(source: KernelSource) -> bytes:
    code = _compile_kernel(source, Signature(source.signature))
    store_code(_file_name(source), code)
    return code


def _link_code(
    signature: Signature, code: bytes, compile_with_numba: Callable[[], Callable[..., Any]]
) -> Callable[..., Any]:
    if not code:
        raise _UncacheableKernelError
    (length,) = _HEADER_FORMAT.unpack_from(code)
    symbol = code[_HEADER_FORMAT.size : _HEADER_FORMAT.size + length].decode()
    function = signature.c_function()(
        _load_entry_address(symbol, code[_HEADER_FORMAT.size + length :])
    )

    def run(*args: Any) -> Any:
        is_done, result = signature.call(function, args)
        # The code raised an exception. Run the kernel with numba, which reports the exception.
        return result if is_done else compile_with_numba()(*args)

    return run


def _load_entry_address(symbol: str, code: bytes) -> int:
    """Load the code into this process and return the address of its entry.

    Raises
    ------
    _UncacheableKernelError
        If a symbol or the entry is missing.
    """
    import llvmlite.binding as llvm

    # Kernels with sines call the C math library, which Python need not have loaded.
    llvm.load_library_permanently("libm.so.6")
    if any(llvm.address_of_symbol(name) is None for name in _missing_symbols(code)):
        raise _UncacheableKernelError
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    # One engine for each kernel, because two kernels may contain functions with the same name.
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address = int(engine.get_function_address(symbol))
    if address == 0:
        raise _UncacheableKernelError
    _ENGINES.append(engine)
    return address


def _missing_symbols(code: bytes) -> list[str]:
    """Return the undefined symbols of an ELF object file (*System V ABI*, ch. 4).

    Raises
    ------
    _UncacheableKernelError
        If the file is not a 64-bit little-endian ELF file.
    """
    if code[:6] != b"\x7fELF\x02\x01":  # 64-bit, little-endian
        raise _UncacheableKernelError
    (section_offset,) = struct.unpack_from("<Q", code, 0x28)
    size, count = struct.unpack_from("<HH", code, 0x3A)
    sections = [
        struct.unpack_from("<IIQQQQII", code, section_offset + k * size) for k in range(count)
    ]
    names = []
    for _, kind, _, _, position, length, link, _ in sections:
        if kind != 2:  # the symbol table
            continue
        string_table_offset = sections[link][4]
        for offset in range(position, position + length, 24):
            word, _, _, section = struct.unpack_from("<IBBH", code, offset)
            if word and section == 0:
                start = string_table_offset + word
                names.append(code[start : code.index(b"\0", start)].decode())
    return names


def _compile_kernel(source: KernelSource, signature: Signature) -> bytes:
    """Compile a kernel to object code, preceded by the name of its entry.

    The result is empty if the code requires numba.

    Raises
    ------
    _UncacheableKernelError
        If memory is insufficient.
    """
    import llvmlite.binding as llvm
    import numba

    options: dict[str, Any] = {"nogil": True, "fastmath": source.fastmath, "_nrt": False}
    options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    try:
        compiled_kernel = numba.njit(source.signature, **options)(link_parts(source.function))
        result: Any = next(iter(compiled_kernel.overloads.values()))
        symbol = result.fndesc.llvm_func_name
        arguments = (
            llvm.parse_assembly(result.library.get_llvm_str()).get_function(symbol).arguments
        )
        _, form, (code, *_) = result.library.serialize_using_object_code()
    except MemoryError as error:
        # The kernel can be compiled later.
        raise _UncacheableKernelError from error
    # This includes versions of numba that do not support these arguments. numba then compiles the
    # kernel in its usual way and reports any errors in the kernel itself.
    except Exception:  # noqa: BLE001
        return b""
    is_cacheable = (
        form == "object"
        and [_type_name(argument.type) for argument in arguments] == signature.llvm_types()
        and not any(name.startswith(NUMBA_SYMBOLS) for name in _missing_symbols(code))
    )
    return _HEADER_FORMAT.pack(len(symbol)) + symbol.encode() + code if is_cacheable else b""


def _type_name(llvm_type: Any) -> str:
    """Return the name of a type; llvmlite before 0.45 includes the target type of pointers."""
    name = str(llvm_type)
    return "ptr" if name.endswith("*") else name


# --- code in the program ------------------------------------------------------------------------


def baseline_code(source: KernelSource) -> tuple[str, bytes]:
    """Compile a kernel for the baseline of this architecture.

    numba must have been imported with the environment variables NUMBA_CPU_NAME and
    NUMBA_CPU_FEATURES of the baseline.

    Parameters
    ----------
    source : KernelSource

    Returns
    -------
    tuple of str and bytes
        Name and content of its file in `INCLUDED_FOLDER`. The code is empty if the kernel requires
        numba.
    """
    code = _compile_kernel(source, Signature(source.signature))
    return _included_file_name(source), _add_checksum(code)


def _included_code(source: KernelSource) -> bytes | None:
    """Return the code of a kernel that the program contains, or None."""
    import llvmlite.binding as llvm

    baseline = BASELINES.get(platform.machine())
    if baseline is None:
        return None
    features = llvm.get_host_cpu_features()
    if not all(features.get(name) for name in baseline.features):
        return None
    try:
        folder = resource("kernels", INCLUDED_FOLDER)
    except InputError:
        # A checkout does not contain the code.
        return None
    return _read_code(folder / _included_file_name(source)) or None


def _included_file_name(source: KernelSource) -> str:
    return _name(source, (BASELINES[platform.machine()].cpu,))


# --- files in the cache -------------------------------------------------------------------------


def cache_folders() -> Iterator[Path]:
    """Yield the folders that may contain compiled kernels, in order of preference.

    The folder of the package is not among them: it may be read-only, belong to another user, or be
    removed by a package manager.
    """
    if folder := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(folder)
        return
    yield user_cache("kernels")
    # For users whose home directory is not writable.
    yield state_folder() / "kernels"


def numba_cache_folder(source: KernelSource) -> Path | None:
    """Return a folder for numba's own cache of one kernel, or None if none is writable.

    numba recognises a changed kernel by the modification time and size of its file. It misses
    changes to functions that the kernel calls from other files, so the name of the folder contains
    a hash of all of them.

    Parameters
    ----------
    source : KernelSource

    Returns
    -------
    Path or None
    """
    try:
        name = _file_name(source).removesuffix(".code")
    except _UncacheableKernelError:
        return None
    kernel, _, digest = name.rpartition("-")
    # Use short names, because numba appends long ones and Windows limits paths to 260 characters.
    kernel = hashlib.blake2b(kernel.encode(), digest_size=4).hexdigest()
    for parent in cache_folders():
        folder = parent / f"{kernel}-{digest}.numba"
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            _remove_outdated_code(parent, kernel, "numba")
            if os.access(folder, os.W_OK):
                return folder
    return None


def load_code(name: str) -> bytes | None:
    """Return the code stored under a name, or None if it is missing or damaged.

    Parameters
    ----------
    name : str
        Name of the file in the cache.

    Returns
    -------
    bytes or None
    """
    codes = (_read_code(folder / name) for folder in cache_folders())
    return next((code for code in codes if code is not None), None)


def _read_code(path: Path) -> bytes | None:
    with contextlib.suppress(OSError, InputError):
        content = read_whole_file(path)
        code = content[len(_FILE_SIGNATURE) + _DIGEST_BYTES :]
        if content == _add_checksum(code):
            return code
    return None


def _add_checksum(code: bytes) -> bytes:
    return _FILE_SIGNATURE + hashlib.blake2b(code, digest_size=_DIGEST_BYTES).digest() + code


def store_code(name: str, code: bytes) -> None:
    """Store code in the first writable cache folder, if any.

    Parameters
    ----------
    name : str
        Name of the file in the cache.
    code : bytes
    """
    for folder in cache_folders():
        temporary_path = folder / f"{name}.{os.getpid()}.part"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            temporary_path.write_bytes(_add_checksum(code))
            temporary_path.replace(folder / name)
            _remove_outdated_code(folder, name.rpartition("-")[0], "code")
            return
        except OSError:
            with contextlib.suppress(OSError):
                temporary_path.unlink(missing_ok=True)


def _remove_outdated_code(folder: Path, kernel: str, suffix: str) -> None:
    """Remove all but the newest files of a kernel.

    The removed files usually belong to earlier versions of the program or to other machines.
    """
    entries = sorted(folder.glob(f"{kernel}-*.{suffix}"), key=lambda entry: entry.stat().st_mtime)
    for entry in entries[:-MAX_VERSIONS]:
        if entry.is_dir():
            shutil.rmtree(entry, ignore_errors=True)
        else:
            entry.unlink(missing_ok=True)


def _file_name(source: KernelSource) -> str:
    return _name(source, _environment())


def _name(source: KernelSource, environment: tuple[str, ...]) -> str:
    digest = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for word in (*environment, source.signature, str(source.fastmath)):
        digest.update(f"{word}\n".encode())
    for word in _code_dependencies(source.function):
        digest.update(f"{len(word)} {word}\n".encode())
    qualified_name = f"{source.function.__module__}.{source.function.__name__}"
    return f"{re.sub(r'[^A-Za-z0-9_.]', '_', qualified_name)}-{digest.hexdigest()}.code"


@cache
def _environment() -> tuple[str, ...]:
    """Return everything outside a kernel that determines its machine code.

    Raises
    ------
    _UncacheableKernelError
        If numba is not installed.
    """
    import llvmlite
    import llvmlite.binding as llvm

    compiler_settings = describe_compiler()
    if not compiler_settings[0]:
        raise _UncacheableKernelError
    return (
        *compiler_settings,
        llvmlite.__version__,
        llvm.get_process_triple(),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
    )


def describe_compiler() -> tuple[str, ...]:
    """Return the version and the settings of the compiler without importing it.

    The first item is the version of numba, or "" if numba is not installed.
    """
    spec = find_spec("numba")
    library_path = None if spec is None else spec.origin
    settings = [f"{k}={v}" for k, v in sorted(os.environ.items()) if k.startswith("NUMBA_")]
    return (
        read_small_text(Path(library_path).with_name("_version.py")) if library_path else "",
        sys.version,
        *(word for word in settings if not word.startswith("NUMBA_CACHE_DIR=")),
    )


def _code_dependencies(function: Callable[..., Any]) -> Iterator[str]:
    """Yield everything that the machine code of a function depends on.

    These are the instructions, the constants and the values of the names that the function and the
    functions it calls use.
    """
    assert isinstance(function, FunctionType)
    codes = all_code_objects(function)
    for code in codes:
        yield code.co_code.hex()
        yield code.co_exceptiontable.hex()
        yield repr(
            [
                _order_sets(co_const)
                for co_const in code.co_consts
                if not isinstance(co_const, CodeType)
            ]
        )
        yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))
        yield repr((code.co_argcount, code.co_flags))
    used_globals = {
        co_name for code in codes for co_name in code.co_names if co_name in function.__globals__
    }
    for name in sorted(used_globals):
        yield name
        yield from _value_dependencies(function.__globals__[name])
    values = [cell.cell_contents for cell in function.__closure__ or ()]
    for value in [*values, *(function.__defaults__ or ())]:
        yield from _value_dependencies(value)


def _order_sets(constant: Any) -> Any:
    """Sort a constant if it is a set, because the order of a set differs between processes."""
    return sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant


def _value_dependencies(value: Any) -> Iterator[str]:
    if isinstance(value, KernelPart):
        yield repr(sorted(value.options.items()))
        yield from _code_dependencies(value.function)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype.str} {value.shape} {value.strides} {value.tobytes().hex()}"
    elif isinstance(value, ModuleType):
        yield value.__name__
    elif isinstance(value, type | BuiltinFunctionType | np.ufunc):
        yield f"{value.__module__}.{value.__qualname__}" if isinstance(value, type) else repr(value)
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        yield repr(value)
    elif isinstance(value, tuple):
        yield str(len(value))
        for item in value:
            yield from _value_dependencies(item)
    else:
        raise _UncacheableKernelError
