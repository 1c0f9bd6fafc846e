# robcl_arm(rx90) defines the program robcl-rx90, which serves exactly the arm that devices/arms/rx90.toml and rx90.urdf
# describe. Its source is the file main.cpp in the folder of the CMakeLists.txt that calls robcl_arm. The program contains the
# texts of both files, so that it runs from any folder. C++ code links the library devices_rx90_files and includes these
# texts as "devices/rx90/rx90_files.hpp".
function(robcl_arm name)
  foreach(kind toml urdf)
    set(file "${PROJECT_SOURCE_DIR}/devices/arms/${name}.${kind}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
    file(READ "${file}" ${kind})
  endforeach()
  configure_file("${PROJECT_SOURCE_DIR}/devices/arm/files.hpp.in"
    "${CMAKE_CURRENT_BINARY_DIR}/include/devices/${name}/${name}_files.hpp" @ONLY)
  add_library(devices_${name}_files INTERFACE)
  target_include_directories(devices_${name}_files INTERFACE "${CMAKE_CURRENT_BINARY_DIR}/include")
  target_link_libraries(devices_${name}_files INTERFACE devices_arm_file)

  add_executable(robcl-${name} main.cpp)
  target_link_libraries(robcl-${name} PRIVATE devices_${name}_files devices_arm_object)
endfunction()
