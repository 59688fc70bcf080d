#!/bin/sh
# VOM Studio @VERSION@ as one file: this script, then a squashfs file system at byte @OFFSET@.
#
#   ./@NAME@ [ARGUMENTS]    the same as `vomstudio [ARGUMENTS]`
#
# It needs squashfuse (the file system is mounted while the program runs) or unsquashfs
# (the file system is unpacked to the user's cache once, 2 GB). By hand:
#   sudo mount -o loop,ro,offset=@OFFSET@ @NAME@ FOLDER
#   unsquashfs -offset @OFFSET@ -dest FOLDER @NAME@
set -eu

image="$(readlink -f "$0")"
# Named by entries in the menu of the desktop.
export VOMSTUDIO_LAUNCHER="$image"

start() { # folder, arguments
    folder="$1"
    shift
    exec "$folder"/python/@PYTHON@ -P -m vomstudio "$@"
}

fail() {
    printf '%s\n' "$*" >&2
    exit 1
}

runtime="${XDG_RUNTIME_DIR:-${TMPDIR:-/tmp}}"
mounted="$runtime/vomstudio-$(id -u)-@DIGEST@"
cache="${XDG_CACHE_HOME:-$HOME/.cache}/vomstudio"
unpacked="$cache/bundle-@DIGEST@"

# Unpacked by an earlier start: starts from there are faster.
[ -e "$unpacked/vomstudio" ] && start "$unpacked" "$@"

if command -v squashfuse >/dev/null && [ -w /dev/fuse ]; then
    # A second window uses the mount of the first. A folder of that name that belongs to somebody
    # else is not trusted.
    mkdir -m 700 "$mounted" 2>/dev/null || [ -O "$mounted" ] || fail \
        "Cannot mount VOM Studio at $mounted: it belongs to another user. Set XDG_RUNTIME_DIR."
    [ -e "$mounted/vomstudio" ] ||
        squashfuse -o offset=@OFFSET@,ro "$image" "$mounted" >/dev/null 2>&1 || true
    if [ -e "$mounted/vomstudio" ]; then
        # Unmounts after this process, which becomes the program. As long as another window uses
        # the mount it is busy and stays.
        (
            trap '' HUP INT TERM
            tail --pid="$$" -s 5 -f /dev/null
            sleep 2
            fusermount -u "$mounted" || fusermount3 -u "$mounted"
        ) </dev/null >/dev/null 2>&1 &
        start "$mounted" "$@"
    fi
fi

command -v unsquashfs >/dev/null || fail \
    "Cannot open the file system in $image. Install squashfuse or squashfs-tools."
mkdir -p "$cache"
printf 'Unpacking VOM Studio to %s (2 GB, once)\n' "$unpacked" >&2
part="$(mktemp -d "$cache/bundle.XXXXXX")"
trap 'rm -rf "$part"' EXIT
trap 'exit 130' HUP INT TERM
unsquashfs -quiet -no-progress -offset @OFFSET@ -dest "$part/bundle" "$image" >&2 || fail \
    "Cannot unpack VOM Studio to $cache. Free 3 GB there, or set XDG_CACHE_HOME to another folder."
# Another start may have been faster.
mv -T "$part/bundle" "$unpacked" 2>/dev/null || [ -e "$unpacked/vomstudio" ]
rm -rf "$part"
trap - EXIT HUP INT TERM
start "$unpacked" "$@"
