#!/bin/sh
# apt.sh LIST: installs the Debian packages of LIST that are missing where it may (root, or sudo without a password);
# else names them and fails. Not on Debian: says what is needed and goes on. CPM_APT=no: does nothing.
set -eu
[ "${CPM_APT:-yes}" != no ] || exit 0
list=$(sed 's/#.*//' "$1" | tr -s ' \n' '  ')

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "Not a Debian system. These Debian packages, under your system's names, are needed:$list" >&2
    exit 0
fi
missing=
for package in $list; do
    case $(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true) in
    *" installed") ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=
elif sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    echo "These packages are missing, and installing them takes root:" >&2
    echo "    sudo apt-get install$missing" >&2
    echo "(CPM_APT=no goes on without: set it if they came another way.)" >&2
    exit 1
fi
echo "installing:$missing"
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get update -qq
# shellcheck disable=SC2086
$as_root apt-get install -y -qq --no-install-recommends $missing
