#!/bin/sh
# Run `colcon build --paths . msg_defs` with the ROS 2 wheels of a virtual environment. Where ROS 2
# itself is installed and sourced, that plain command does the same.
#
# usage: tools/colcon_build.sh VENV [ARGUMENT OF colcon build]...
set -eu

venv=$(cd "$1" && pwd)
tools=$(cd "$(dirname "$0")" && pwd)
shift

unset PYTHONPATH COLCON_PREFIX_PATH
export AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" PATH="$venv/bin:$PATH"
cd "$tools/.."
# colcon looks for no further packages below the root one, so msg_defs is named beside it.
exec colcon build --paths . msg_defs "$@" --cmake-args \
    -DBUILD_TESTING=OFF \
    -DCMAKE_PROJECT_INCLUDE="$tools/cmake/ros_wheels.cmake" \
    -DPython3_EXECUTABLE="$venv/bin/python"
