# robcl_arm(rx90) defines the program robcl-rx90. Its sources are the files main.cpp and rx90.urdf in the folder of the
# CMakeLists.txt that calls robcl_arm. The program contains the text of the URDF file, so that it runs from any folder. C++ code
# links the library devices_rx90_urdf and includes this text as "rx90/rx90_urdf.hpp".
function(robcl_arm name)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${name}.urdf)
  file(READ ${name}.urdf urdf)
  configure_file("${PROJECT_SOURCE_DIR}/devices/arm/urdf.hpp.in"
    "${CMAKE_CURRENT_BINARY_DIR}/include/${name}/${name}_urdf.hpp" @ONLY)
  add_library(devices_${name}_urdf INTERFACE)
  target_include_directories(devices_${name}_urdf INTERFACE "${CMAKE_CURRENT_BINARY_DIR}/include")

  add_executable(robcl-${name} main.cpp)
  target_link_libraries(robcl-${name} PRIVATE devices_${name}_urdf devices_arm_object)
endfunction()
