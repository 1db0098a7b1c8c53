#!/bin/sh
# Build the interface package msg_defs/ and install it into a virtual environment with the ROS 2
# wheels, where `import spacecraft_gnc_msgs` then finds it.
#
# usage: tools/build_messages.sh VENV
set -eu

venv=$(cd "$1" && pwd)
tools=$(cd "$(dirname "$0")" && pwd)
build=$venv/build/spacecraft_gnc_msgs
installed=$build/install_manifest.txt
log=$build/log.txt

quietly() {
    if ! "$@" >>"$log" 2>&1; then
        cat "$log" >&2
        echo "error: the messages were not built: this failed: $*" >&2
        exit 1
    fi
}

# Start afresh, so that a message taken out of msg_defs/ does not live on in the environment.
if [ -f "$installed" ]; then
    xargs -d '\n' rm -f <"$installed"
fi
rm -rf "$build"
mkdir -p "$build"

# cmake, ninja and the generators are those of the environment; a ROS 2 that the shell may have
# sourced stays out of it.
unset PYTHONPATH COLCON_PREFIX_PATH
export AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" PATH="$venv/bin:$PATH"
quietly cmake -S "$tools/../msg_defs" -B "$build" -G Ninja \
    -DBUILD_TESTING=OFF \
    -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_INSTALL_PREFIX="$venv" \
    -DCMAKE_PROJECT_INCLUDE="$tools/cmake/ros_wheels.cmake" \
    -DPython3_EXECUTABLE="$venv/bin/python"
quietly cmake --build "$build"
quietly cmake --install "$build"
