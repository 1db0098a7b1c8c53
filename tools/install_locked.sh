#!/bin/sh
# Install exactly the files of a lock into a virtual environment. Nothing is resolved, so that a newer
# release on the index changes nothing.
#
# usage: tools/install_locked.sh VENV LOCK
set -eu

venv=$1
lock=$2
pip() {
    "$venv/bin/python" -m pip "$@"
}
# Modules are compiled when first imported: most of what is installed here never is.
install() {
    pip install -qq --no-compile --no-deps --require-hashes "$@"
}

# What the index has as source only is built with the locked setuptools and wheel; pip would fetch
# the newest ones for it.
builders=$(mktemp)
trap 'rm -f "$builders"' EXIT
awk '/^[A-Za-z0-9]/ { wanted = /^(setuptools|wheel)==/ } wanted' "$lock" >"$builders"
[ ! -s "$builders" ] || install -r "$builders"
install --no-build-isolation -r "$lock"
pip check -q
