#!/bin/sh
# Print the Python to build the virtual environment with. Where this machine lacks something, say in
# one line each what it is and how to get it, and fail.
#
# usage: tools/prerequisites.sh [PYTHON]      PYTHON: the only interpreter to consider
set -eu

complete=yes
missing() {
    printf 'error: %s\n' "$1" >&2
    complete=no
}

suits() {
    "$1" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null
}

find_python() {
    for candidate in "$@"; do
        if suits "$candidate"; then
            echo "$candidate"
            return
        fi
    done
}

first_command() {
    for candidate in "$@"; do
        if command -v "$candidate" >/dev/null; then
            echo "$candidate"
            return
        fi
    done
}

system=$(uname -sm)
if [ "$system" != "Linux x86_64" ]; then
    missing "this is $system, the ROS 2 wheels are for Linux on x86_64: use such a machine, a virtual one or a container"
elif ! getconf GNU_LIBC_VERSION >/dev/null 2>&1; then
    missing "the C library is not glibc, the ROS 2 wheels need glibc 2.28 or later: use a distribution such as Debian or Ubuntu"
fi

if [ $# -gt 0 ] && [ -n "$1" ]; then
    python=$(find_python "$1")
else
    python=$(find_python python3 python3.11 python3.12 python3.13 python3.14 python3.10)
fi

if [ -z "$python" ] && [ -n "${1:-}" ]; then
    missing "$1 is not Python 3.10 to 3.14: name one that is, or leave PYTHON unset"
elif [ -z "$python" ]; then
    missing "Python 3.10 to 3.14 not found: install it (Debian, Ubuntu: apt install python3 python3-venv python3-dev) or name one, make PYTHON=/path/to/python3"
else
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        missing "$python has no venv module: install it (Debian, Ubuntu: apt install python3-venv)"
    fi
    if ! "$python" -c 'import os, sysconfig; os.stat(sysconfig.get_path("include") + "/Python.h")' 2>/dev/null; then
        missing "$python has no header Python.h: install it (Debian, Ubuntu: apt install python3-dev)"
    fi
fi

if [ -z "$(first_command "${CC:-cc}" gcc clang)" ] || [ -z "$(first_command "${CXX:-c++}" g++ clang++)" ]; then
    missing "no C and C++ compiler: install both (Debian, Ubuntu: apt install build-essential) or set CC and CXX"
fi

[ "$complete" = yes ] || exit 1
# The interpreter behind an environment: the one that is active may be about to be replaced.
"$python" -c 'import sys; print(getattr(sys, "_base_executable", sys.executable))'
