# Sourced by packaging/run and packaging/test: makes the machine ready, once.
#
# After `prepare run`, $root is the project's folder and $python the interpreter of .venv/, which
# contains the packages of requirements.lock and the project itself; after `prepare test` also those
# of requirements_test.lock. All messages go to standard error; a second call takes no time.

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)"
root="$(dirname "$here")"
venv="$root/.venv"
python="$venv/bin/python"
stamp="$venv/installed-from"
unfinished="$venv/installation-unfinished"

say() { printf '%s\n' "$*" >&2; }
die() {
    say "$*"
    exit 1
}

locks() { # run | test
    printf '%s\n' "$here/requirements.lock"
    [[ "$1" == run ]] || printf '%s\n' "$here/requirements_test.lock"
}

# Contents of the stamp of a finished installation: a moved or changed project has another one.
wanted_stamp() { # run | test
    printf 'folder %s\n' "$root"
    local lock
    while read -r lock; do cat "$lock"; done < <(locks "$1")
    cat "$root/pyproject.toml"
}

is_installed() { # run | test
    [[ -x "$python" && ! -e "$unfinished" ]] || return 1
    wanted_stamp "$1" | cmp -s - "$stamp-$1"
}

# --- system packages ---------------------------------------------------------------------------

can_use_apt() {
    command -v apt-get >/dev/null || return 1
    [[ "$(id -u)" == 0 ]] || sudo -n true 2>/dev/null
}

apt() {
    local as_root=()
    [[ "$(id -u)" == 0 ]] || as_root=(sudo -n)
    ${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive \
        apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" >&2 </dev/null
}

is_there() { # package, library or program
    # No pipes into grep -q here: it stops reading early, and pipefail takes that for a failure.
    local known
    # Ubuntu 24.04 and Debian 13 renamed some libraries: same library, name ending in t64.
    known="$(dpkg-query -W -f '${Status}\n' "$1" "$1t64" 2>/dev/null || true)"
    [[ "$known" == *"install ok installed"* ]] && return 0
    case "$2" in
        lib*)
            known="$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null || true)"
            [[ "$known" == *"$2 "* ]]
            ;;
        *) command -v "$2" >/dev/null ;;
    esac
}

missing_system_packages() { # run | test
    local package library use _why
    while read -r package library use _why; do
        [[ -z "$package" || "$package" == "#"* ]] && continue
        [[ "$use" == run || "$use" == "$1" ]] || continue
        is_there "$package" "$library" || printf '%s\n' "$package"
    done <"$here/system_packages.txt"
}

install_system_packages() { # run | test
    [[ "$(uname -s)" == Linux ]] || return 0
    local missing
    missing="$(missing_system_packages "$1")"
    [[ -n "$missing" ]] || return 0
    # Names hold no spaces, so splitting is meant.
    # shellcheck disable=SC2086
    if can_use_apt; then
        say "Installing system packages:" $missing
        if ! { apt update && apt install --no-install-recommends $missing; }; then
            say "Some system packages could not be installed; going on without them."
        fi
    else
        say "These system packages are missing and can't be installed without root rights or sudo:"
        say " " $missing
        say "On Debian or Ubuntu: sudo apt-get install" $missing
        say "(packaging/system_packages.txt says what each is for). Going on without them."
    fi
}

# --- Python ------------------------------------------------------------------------------------

find_python() { # prints an interpreter that can make the environment
    local candidate
    for candidate in ${VOMSTUDIO_PYTHON:+"$VOMSTUDIO_PYTHON"} python3 python3.13 python3.12 \
        python3.11 python3.14 python; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null &&
            "$candidate" -c 'import ensurepip, venv' 2>/dev/null; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done
    return 1
}

need_python() {
    find_python && return 0
    if can_use_apt; then
        say "Installing Python"
        if apt update && apt install --no-install-recommends python3 python3-venv; then
            find_python && return 0
        fi
    fi
    die "Python 3.11 or newer with its venv module is needed, and none was found. On Debian 12 or" \
        "Ubuntu 24.04 and later: sudo apt-get install python3 python3-venv. A Python elsewhere can" \
        "be named: VOMSTUDIO_PYTHON=/path/to/python3.12 $0"
}

environment_is_usable() {
    [[ -x "$python" && ! -e "$unfinished" ]] || return 1
    # A moved folder leaves scripts behind that point to the old place.
    [[ ! -f "$stamp-run" || "$(head -n 1 "$stamp-run")" == "folder $root" ]] || return 1
    "$python" -c 'import sys, pip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null
}

install_environment() { # run | test
    if ! environment_is_usable; then
        local base
        base="$(need_python)"
        say "Making .venv with $("$base" --version)"
        rm -rf "$venv"
        mkdir "$venv"
        : >"$unfinished"
        "$base" -m venv "$venv"
    fi
    : >"$unfinished"
    say "Installing Python packages into .venv (3.3 GB once unpacked, a few minutes)"
    local pip=("$python" -m pip --disable-pip-version-check --quiet)
    # setuptools first: what has no wheel is then built with the locked one, not with whatever is
    # newest, and so is the project itself.
    sed -n '/^setuptools==/,/[^\\]$/p' "$here/requirements.lock" >"$venv/setuptools.txt"
    "${pip[@]}" install --require-hashes --requirement "$venv/setuptools.txt" >&2
    local lock requirements=()
    while read -r lock; do requirements+=(--requirement "$lock"); done < <(locks "$1")
    "${pip[@]}" install --require-hashes "${requirements[@]}" --no-build-isolation --use-pep517 >&2
    "${pip[@]}" install --no-deps --no-build-isolation --editable "$root" >&2
    # pip does this for the packages; where the user's Python may not write bytecode, every start
    # would translate our own again.
    "$python" -m compileall -q "$root/vomstudio" >&2 || true
    compile_kernels
    local use
    for use in run $([[ "$1" == run ]] || printf test); do
        wanted_stamp "$use" >"$stamp-$use.new"
        mv "$stamp-$use.new" "$stamp-$use"
    done
    rm "$unfinished"
}

# Compiled once here, so that the first model does not wait for it.
compile_kernels() {
    (cd "$root" && "$python" - >&2) <<'PYTHON' || say "Kernels will be compiled when first used."
try:
    from vomstudio.io.models.formats.obj import warm_up
except ImportError:
    warm_up = None
if warm_up:
    warm_up()
PYTHON
}

# --- the door ----------------------------------------------------------------------------------

prepare() { # run | test
    install_system_packages "$1"
    is_installed "$1" && return 0
    # Two first starts at the same time: the second waits, then finds the work done.
    if command -v flock >/dev/null; then
        exec 9<"$here"
        flock 9
    fi
    is_installed "$1" || install_environment "$1"
    if command -v flock >/dev/null; then
        exec 9<&-
    fi
}
