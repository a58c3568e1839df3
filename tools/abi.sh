#!/bin/sh
# abi.sh check|write LIBRARY HEADERS FOLDER: the public ABI of LIBRARY, as abidw sees it through HEADERS, against the
# baseline FOLDER/libcpm-N.abi (check), or written there (write). New functions pass. A field added at the end of a
# descriptor is compatible (struct_size) but shown, since abidiff cannot know: look, then write a new baseline.
set -eu
command=$1
library=$2
headers=$3
baseline=$4/$(basename "$library" | sed 's/\.so\./-/').abi # libcpm.so.0: libcpm-0.abi
now=$(mktemp)
trap 'rm -f "$now"' EXIT

# No file names, lines or folders: the baseline says nothing about the machine that wrote it.
abidw --headers-dir "$headers" --suppressions "$(dirname "$0")/abi.suppr" --exported-interfaces-only \
    --no-show-locs --no-corpus-path --no-comp-dir-path --no-elf-needed --out-file "$now" "$library"
case $command in
write)
    mkdir -p "$4"
    cat "$now" >"$baseline"
    echo "wrote $baseline"
    ;;
check)
    if [ ! -e "$baseline" ]; then
        echo "there is no baseline $baseline; 'make abi-baseline' writes it" >&2
        exit 1
    fi
    abidiff --no-added-syms "$baseline" "$now" || {
        echo "the ABI is not that of $baseline. A break: raise CPM_ABI in CMakeLists.txt. Either way, once it is meant:" \
            "make abi-baseline" >&2
        exit 1
    }
    echo "the ABI is that of $baseline, additions apart"
    ;;
esac
