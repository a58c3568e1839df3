#!/bin/sh
# install_test.sh SOURCE BUILD CMAKE: installs into an empty prefix, moves it, and builds and runs examples/c/room there
# twice, by find_package(cpm) and by pkg-config. What a user of the C library does first.
set -eu
source=$1
build=$2
cmake=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset PKG_CONFIG_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH

"$cmake" --install "$build" --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix" # an installation can be moved
libdir=$(dirname "$(find "$work/prefix" -name libcpm.so)")

test -f "$work/prefix/include/cpm/cpm.h"
test -f "$libdir/libcpm.so.0"
test "$(readlink "$libdir/libcpm.so")" = libcpm.so.0
test -f "$libdir/pkgconfig/cpm.pc"
test -f "$libdir/cmake/cpm/cpmConfig.cmake"
if find "$work/prefix" -name '*.py' -o -name '_core*' | grep .; then
    echo "a plain install holds Python" >&2
    exit 1
fi
if grep -rIl -e "$source" -e "$build" -e "$work/first" "$libdir/pkgconfig" "$libdir/cmake"; then
    echo "an installed file names the build's own folders" >&2
    exit 1
fi

echo "== find_package(cpm)"
"$cmake" -S "$source/examples/c" -B "$work/room" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS=-Werror >"$work/configure.log"
"$cmake" --build "$work/room" >"$work/build.log" || { cat "$work/build.log"; exit 1; }
"$work/room/room" --size 40x30 --photons 20000 --nearest 20 -o "$work/a.exr"

echo "== pkg-config"
PKG_CONFIG_PATH=$libdir/pkgconfig make -s -C "$source/examples/c" OUT="$work/room-pc" CFLAGS="-O0 -Werror"
LD_LIBRARY_PATH=$libdir "$work/room-pc" --curved --size 40x30 --photons 20000 --nearest 20 -o "$work/b.exr"

if "$work/room-pc" --photons minus >/dev/null 2>&1; then
    echo "room took a bad number" >&2
    exit 1
fi
for file in a b; do
    if [ -e "$work/$file.exr" ]; then
        test "$(od -An -tx1 -N4 "$work/$file.exr" | tr -d ' ')" = 762f3101 # OpenEXR's magic number
    fi
done
echo "both built, both ran"
