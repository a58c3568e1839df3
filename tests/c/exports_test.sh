#!/bin/sh
# exports_test.sh LIBRARY HEADERS: the library exports exactly the functions that the public headers declare.
set -eu
library=$1
headers=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A declaration begins with CPM_API; its name is the last cpm_ word before the first parenthesis.
cat "$headers"/*.h | sed -n 's/^CPM_API \([^(]*\)(.*/\1/p' | grep -o 'cpm_[a-z0-9_]*$' | sort -u >"$work/declared"
nm -D --defined-only "$library" | awk '$2 != "A" { sub(/@.*/, "", $3); print $3 }' | sort -u >"$work/exported"
diff -u "$work/declared" "$work/exported" || {
    echo "lines with -: declared, not exported; with +: exported, not declared" >&2
    exit 1
}
echo "$(wc -l <"$work/declared") functions declared and exported"

soname=$(objdump -p "$library" | awk '$1 == "SONAME" { print $2 }')
case $soname in
libcpm.so.[0-9]*) echo "SONAME $soname" ;;
*) echo "SONAME is '$soname', not libcpm.so.N" >&2; exit 1 ;;
esac
