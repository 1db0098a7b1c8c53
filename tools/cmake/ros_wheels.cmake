# Let CMake use the ROS 2 Python wheels. Pass it as -DCMAKE_PROJECT_INCLUDE=<this file>; it is not
# needed, and changes nothing, where ROS 2 itself is installed.
#
# The targets that the wheels export name the include folder of the Python they were built with,
# /opt/python/..., and CMake refuses an imported target whose include folder does not exist. The
# interface package must stay a stock one, so the folders are dropped here instead: at the end of
# the project, when find_package() has created every imported target. FindPython3 supplies the
# right include folder.
cmake_minimum_required(VERSION 3.20)

function(drop_build_farm_include_folders)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(folders)
      list(FILTER folders EXCLUDE REGEX "^/opt/python/")
      set_property(TARGET ${target} PROPERTY INTERFACE_INCLUDE_DIRECTORIES ${folders})
    endif()
  endforeach()
endfunction()

cmake_language(DEFER CALL drop_build_farm_include_folders)
