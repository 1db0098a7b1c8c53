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

# The generated sources of one library include the same large headers: compiled as one file they
# take a fraction of the time. Those of the C structures define equal names, so they stay apart.
function(compile_libraries_as_one_file)
  get_property(targets DIRECTORY PROPERTY BUILDSYSTEM_TARGETS)
  list(FILTER targets EXCLUDE REGEX "__rosidl_generator_c$")
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "SHARED_LIBRARY")
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    endif()
  endforeach()
endfunction()

cmake_language(DEFER CALL drop_build_farm_include_folders)
cmake_language(DEFER CALL compile_libraries_as_one_file)
