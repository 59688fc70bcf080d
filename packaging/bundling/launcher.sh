#!/bin/sh
# Starts VOM Studio from this folder, wherever it was moved to.
here="$(dirname "$(readlink -f "$0")")"
# Named by entries in the menu of the desktop.
export VOMSTUDIO_LAUNCHER="$here/vomstudio"
exec "$here"/python/@PYTHON@ -P -m vomstudio "$@"
