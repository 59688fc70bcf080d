#!/bin/sh
# VOM Studio @VERSION@ as one file: this script, then a squashfs file system at byte @OFFSET@.
#
#   ./@NAME@ [ARGUMENTS]    the same as `vomstudio [ARGUMENTS]`
#
# It needs squashfuse and fuse3 (the file system is mounted while the program runs) or unsquashfs
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
mounts="$runtime/vomstudio-$(id -u)"
mounted="$mounts/@DIGEST@"
cache="${XDG_CACHE_HOME:-$HOME/.cache}/vomstudio"
unpacked="$cache/bundle-@DIGEST@"

# Unpacked by an earlier start: starts from there are faster.
[ -e "$unpacked/vomstudio" ] && start "$unpacked" "$@"

if command -v squashfuse >/dev/null && [ -w /dev/fuse ]; then
    # A second window uses the mount of the first. A folder of that name that belongs to somebody
    # else is not trusted.
    mkdir -m 700 "$mounts" 2>/dev/null || [ -O "$mounts" ] || fail \
        "Cannot mount VOM Studio in $mounts: it belongs to another user. Set XDG_RUNTIME_DIR."
    mkdir "$mounted" 2>/dev/null || true
    [ -e "$mounted/vomstudio" ] ||
        squashfuse -o offset=@OFFSET@,ro "$image" "$mounted" >/dev/null 2>&1 || true
    if [ -e "$mounted/vomstudio" ]; then
        # Unmounts after this process, which becomes the program; it is not a child of it. As long
        # as another window uses the mount it is busy and stays.
        (
            trap '' HUP INT TERM
            {
                tail --pid="$$" -s 5 -f /dev/null
                for _ in 1 2 3 4 5; do
                    sleep 2
                    fusermount3 -u "$mounted" || fusermount -u "$mounted" && break
                done
                rmdir "$mounted" "$mounts"
            } </dev/null >/dev/null 2>&1 &
        )
        start "$mounted" "$@"
    fi
    rmdir "$mounted" "$mounts" 2>/dev/null || true
fi

command -v unsquashfs >/dev/null || fail \
    "Cannot open the file system in $image. Install squashfuse and fuse3, or squashfs-tools."
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
