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
log="$venv/installation.log"
# Measured by a fresh installation on Linux.
needed_mb=2700
size_text="700 MB to download, 2.6 GB on disk, a few minutes"

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
        apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" >>"$log" 2>&1 </dev/null
}

install_by_apt() { # packages
    say "Installing system packages: $*"
    mkdir -p "$venv" 2>/dev/null || return 1
    apt update && apt install --no-install-recommends "$@"
}

missing_system_packages() { # run | test
    # No pipes into grep -q here: it stops reading early, and pipefail takes that for a failure.
    local installed libraries package library use _why
    installed="$(dpkg-query -W -f '<${Package} ${db:Status-Status}>' 2>/dev/null || true)"
    libraries="$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null || true)"
    while read -r package library use _why; do
        [[ -z "$package" || "$package" == "#"* ]] && continue
        [[ "$use" == run || "$use" == "$1" ]] || continue
        # Ubuntu 24.04 and Debian 13 renamed some libraries: same library, name ending in t64.
        [[ "$installed" == *"<$package installed>"* ]] && continue
        [[ "$installed" == *"<${package}t64 installed>"* ]] && continue
        # Installed in another way.
        case "$library" in
            lib*) [[ "$libraries" == *"$library "* ]] && continue ;;
            *) command -v "$library" >/dev/null && continue ;;
        esac
        printf '%s\n' "$package"
    done <"$here/system_packages.txt"
}

install_system_packages() { # run | test
    [[ "$(uname -s)" == Linux ]] || return 0
    local missing
    missing="$(missing_system_packages "$1")"
    [[ -n "$missing" ]] || return 0
    # Names hold no spaces, so splitting is meant.
    # shellcheck disable=SC2086
    set -- $missing
    if ! can_use_apt; then
        say "Going on without system packages that only root can install: sudo apt-get install $*"
    elif ! install_by_apt "$@"; then
        say "Going on without system packages that apt-get could not install ($log): $*"
    fi
}

# --- Python ------------------------------------------------------------------------------------

supported='(3, 11) <= sys.version_info[:2] <= (3, 14)'

find_python() { # prints an interpreter that can make the environment
    local candidate candidates=(python3 python3.13 python3.12 python3.11 python3.14 python)
    [[ -z "${VOMSTUDIO_PYTHON:-}" ]] || candidates=("$VOMSTUDIO_PYTHON")
    for candidate in "${candidates[@]}"; do
        if "$candidate" -c "import sys, ensurepip, venv; sys.exit(not $supported)" 2>/dev/null; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done
    return 1
}

need_python() {
    find_python && return 0
    if [[ -z "${VOMSTUDIO_PYTHON:-}" ]] && can_use_apt; then
        install_by_apt python3 python3-venv && find_python && return 0
    fi
    local name="${VOMSTUDIO_PYTHON:-python3}" found
    found="$("$name" -c "import sys; print('%d.%d' % sys.version_info[:2], $supported)" 2>/dev/null || true)"
    case "$found" in
        "") found="$name was not found" ;;
        *True) found="Python ${found% *} has no venv module (sudo apt-get install python${found% *}-venv)" ;;
        *) found="$name is Python ${found% *}" ;;
    esac
    die "Python 3.11 to 3.14 with its venv module is needed, but $found: install it, or name" \
        "another one by VOMSTUDIO_PYTHON=/path/to/python3.12 $0"
}

environment_is_usable() {
    [[ -x "$python" && ! -e "$venv/creation-unfinished" ]] || return 1
    # A moved folder leaves scripts behind that point to the old place.
    [[ ! -f "$stamp-run" || "$(head -n 1 "$stamp-run")" == "folder $root" ]] || return 1
    "$python" -c "import sys, pip; sys.exit(not $supported)" 2>/dev/null
}

create_environment() {
    local base free
    base="$(need_python)"
    say "Creating .venv with $("$base" --version)"
    # The log stays: it may contain what apt-get reported.
    find "$venv" -mindepth 1 -maxdepth 1 ! -path "$log" -exec rm -rf {} +
    : >"$venv/creation-unfinished"
    free="$(df -Pm "$venv" 2>/dev/null | awk 'NR == 2 {print $4}')"
    [[ -z "$free" || "$free" -ge "$needed_mb" ]] ||
        die "The disk of $root has $free MB left, and $needed_mb MB are needed:" \
            "free some space, then run this again."
    "$base" -m venv "$venv" >>"$log" 2>&1 ||
        die "$base cannot create .venv: $(tail -n 1 "$log") Repair it or name another Python by" \
            "VOMSTUDIO_PYTHON, then run this again."
    rm "$venv/creation-unfinished"
}

install_environment() { # run | test
    mkdir -p "$venv" 2>/dev/null && : >>"$log" 2>/dev/null ||
        die "Cannot write to $root: make it writable, or copy it to a folder of yours."
    trap 'die "The installation was interrupted. Run this again; it continues."' INT TERM
    environment_is_usable || create_environment
    : >"$unfinished"
    say "Installing VOM Studio into .venv ($size_text)"
    local lock locks=()
    while read -r lock; do locks+=("$lock"); done < <(locks "$1")
    "$python" "$here/_install.py" packages "$log" "${locks[@]}"
    "$python" "$here/_install.py" project "$log" "$root"
    # pip does this for the packages; where the user's Python may not write bytecode, every start
    # would translate our own again.
    "$python" -m compileall -q "$root/vomstudio" >>"$log" 2>&1 || true
    say "Compiling numerical kernels"
    compile_kernels
    local use
    for use in run $([[ "$1" == run ]] || printf test); do
        wanted_stamp "$use" >"$stamp-$use.new"
        mv "$stamp-$use.new" "$stamp-$use"
    done
    rm "$unfinished"
    trap - INT TERM
}

# Compiled once here, so that the first model does not wait for it. If that fails, they are compiled
# when they are first used.
compile_kernels() {
    (cd / && "$python" -c "from vomstudio.io.models.formats.obj import warm_up; warm_up()") \
        >>"$log" 2>&1 || true
}

# --- the door ----------------------------------------------------------------------------------

prepare() { # run | test
    install_system_packages "$1"
    is_installed "$1" && return 0
    # Two first starts at the same time: the second waits, then finds the work done.
    if command -v flock >/dev/null; then
        exec 9<"$here"
        flock -n 9 || { say "Waiting for another installation of this folder" && flock 9; }
    fi
    is_installed "$1" || install_environment "$1"
    if command -v flock >/dev/null; then
        exec 9<&-
    fi
}
