# What other projects get by find_package(robcl): from this build folder, or from a folder that
# `cmake --install <build folder> --prefix <folder>` fills and that may be moved. docs/sdk.md says how to use it.
#
# Every library below runtime/cpp and generated/cpp is exported: gecos_x as robcl::gecos_x, robcl_x as robcl::x. Those
# that need KDL and urdfdom are the component `arm`; those below devices/ that serve an arm are the component `arm_server`.
# Of the broker and the devices only the programs are installed.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

# The targets of these kinds that the folder and those below it make.
function(gecos_targets_below directory kinds result)
  set(found "")
  if(EXISTS "${directory}/CMakeLists.txt")
    get_property(targets DIRECTORY "${directory}" PROPERTY BUILDSYSTEM_TARGETS)
    get_property(children DIRECTORY "${directory}" PROPERTY SUBDIRECTORIES)
    foreach(target IN LISTS targets)
      get_target_property(type ${target} TYPE)
      if(type IN_LIST kinds)
        list(APPEND found ${target})
      endif()
    endforeach()
    foreach(child IN LISTS children)
      gecos_targets_below("${child}" "${kinds}" below)
      list(APPEND found ${below})
    endforeach()
  endif()
  set(${result} "${found}" PARENT_SCOPE)
endfunction()

set(runtime "${PROJECT_SOURCE_DIR}/runtime/cpp")
set(generated "${PROJECT_SOURCE_DIR}/generated/cpp")
gecos_targets_below("${runtime}" "STATIC_LIBRARY;INTERFACE_LIBRARY" of_runtime)
gecos_targets_below("${generated}" "STATIC_LIBRARY;INTERFACE_LIBRARY" of_generated)
gecos_targets_below("${runtime}/robcl/arm" STATIC_LIBRARY of_arm)
gecos_targets_below("${runtime}/robcl/motion" STATIC_LIBRARY of_motion)
gecos_targets_below("${runtime}" EXECUTABLE programs)
gecos_targets_below("${PROJECT_SOURCE_DIR}/devices" EXECUTABLE devices)
set(arm_libraries ${of_arm} ${of_motion})
set(server_libraries "")
foreach(folder IN ITEMS drivers support arm)
  gecos_targets_below("${PROJECT_SOURCE_DIR}/devices/${folder}" STATIC_LIBRARY of_folder)
  list(APPEND server_libraries ${of_folder})
endforeach()
set(libraries ${of_runtime} ${of_generated})
list(REMOVE_ITEM libraries gecos_broker ${arm_libraries})
set_target_properties(devices_arm_object PROPERTIES EXPORT_NAME arm_server)
add_library(robcl::arm_server ALIAS devices_arm_object)
foreach(library IN LISTS libraries arm_libraries)
  string(REGEX REPLACE "^robcl_" "" name ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${name})
  add_library(robcl::${name} ALIAS ${library})  # gidl_generate() links by these names, in the tree too
endforeach()

if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

# Objects for link-time optimisation suit one version of one compiler, and a program must be built with the sanitizer of
# its libraries.
if(GECOS_LTO OR GECOS_SANITIZE OR GECOS_FUZZ OR GECOS_PROFILE STREQUAL "record")
  install(CODE "message(FATAL_ERROR \"${PROJECT_BINARY_DIR} was configured with GECOS_LTO, GECOS_SANITIZE, GECOS_FUZZ or \"
                                    \"GECOS_PROFILE=record, so its libraries suit no other project: install from a folder \"
                                    \"without them, such as that of `make build`\")")
endif()

set(libraries_dir "${CMAKE_INSTALL_LIBDIR}")
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/robcl")
set(python_dir "${CMAKE_INSTALL_LIBDIR}/robcl/python")
set(idl_dir "${CMAKE_INSTALL_DATADIR}/robcl/idl")
set(licenses_dir "${CMAKE_INSTALL_DATADIR}/doc/robcl")

install(TARGETS ${libraries} EXPORT robcl DESTINATION "${libraries_dir}" INCLUDES DESTINATION include)
install(TARGETS ${arm_libraries} EXPORT robclArm DESTINATION "${libraries_dir}" INCLUDES DESTINATION include)
install(TARGETS ${server_libraries} EXPORT robclArmServer DESTINATION "${libraries_dir}" INCLUDES DESTINATION include)
install(TARGETS ${programs} ${devices} DESTINATION "${CMAKE_INSTALL_BINDIR}")
install(FILES "${GECOS_LCM_LIBRARY}" DESTINATION "${libraries_dir}/robcl")
install(CODE "set(tree [[${PROJECT_SOURCE_DIR}]])\ninclude([[${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake]])")
install(DIRECTORY idl/ DESTINATION "${idl_dir}")
install(DIRECTORY devices/arms DESTINATION "${CMAKE_INSTALL_DATADIR}/robcl")
get_filename_component(site_packages "${GECOS_LCM_LIBRARY}/../.." ABSOLUTE)
file(GLOB lcm_license "${site_packages}/lcm-*.dist-info/licenses/COPYING")
install(FILES LICENSE DESTINATION "${licenses_dir}")
install(FILES ${lcm_license} DESTINATION "${licenses_dir}" RENAME COPYING.lcm)

# All Python in one folder: the compiler, the runtime with the extensions of this build, the classes of our interfaces.
set(but_sources PATTERN __pycache__ EXCLUDE PATTERN "*.so" EXCLUDE)
install(DIRECTORY codegen/gidl DESTINATION "${python_dir}" ${but_sources} PATTERN include EXCLUDE)
install(DIRECTORY idl/gecos DESTINATION "${python_dir}/gidl/include")  # a symbolic link in the tree
install(DIRECTORY runtime/python/gecos runtime/python/robcl generated/python/robcl generated/python/gecos_idl
  DESTINATION "${python_dir}" ${but_sources})
if(TARGET _core)
  install(TARGETS _core LIBRARY DESTINATION "${python_dir}/gecos")
  install(TARGETS _plans LIBRARY DESTINATION "${python_dir}/gecos/wire")
endif()
# gidl asks installed packages for folders of interfaces.
file(RELATIVE_PATH share_from_package "/${python_dir}/robcl_interfaces" "/${idl_dir}/..")
set(written "${PROJECT_BINARY_DIR}/sdk")
set(metadata "robcl-${PROJECT_VERSION}.dist-info")
file(WRITE "${written}/${metadata}/METADATA" "Metadata-Version: 2.1\nName: robcl\nVersion: ${PROJECT_VERSION}\n")
file(WRITE "${written}/${metadata}/entry_points.txt" "[gidl.interfaces]\nrobcl = robcl_interfaces.idl\n")
file(WRITE "${written}/robcl_interfaces/__init__.py"
  "\"\"\"The folder of our interfaces, for gidl.\"\"\"\n\n"
  "from pathlib import Path\n\n"
  "__path__ = [str((Path(__file__).resolve().parent / \"${share_from_package}\").resolve())]\n")
install(DIRECTORY "${written}/${metadata}" "${written}/robcl_interfaces" DESTINATION "${python_dir}")
file(RELATIVE_PATH python_from_command "/${CMAKE_INSTALL_BINDIR}" "/${python_dir}")
foreach(command "gidl:gidl.cli.main:run:jinja2" "gecos:gecos.cli:main:numpy click rich")
  string(REPLACE ":" ";" words "${command}")
  list(GET words 0 name)
  list(GET words 1 module)
  list(GET words 2 function)
  list(GET words 3 requirements)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/command.py.in" "${written}/${name}" @ONLY)
  install(PROGRAMS "${written}/${name}" DESTINATION "${CMAKE_INSTALL_BINDIR}")
endforeach()

# The package is written twice: for the installation and for this build folder.
set(parts "${PROJECT_SOURCE_DIR}/cmake/Gidl.cmake" "${PROJECT_SOURCE_DIR}/cmake/SystemLibraries.cmake")
set(config "${PROJECT_SOURCE_DIR}/cmake/robclConfig.cmake.in")
set(idl "${idl_dir}")
set(python "${python_dir}")
set(lcm "${libraries_dir}/robcl/liblcm.a")
set(interpreter "")
configure_package_config_file("${config}" "${written}/robclConfig.cmake"
  INSTALL_DESTINATION "${package_dir}" PATH_VARS idl python lcm)
write_basic_package_version_file("${written}/robclConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES ${parts} "${written}/robclConfig.cmake" "${written}/robclConfigVersion.cmake" DESTINATION "${package_dir}")
install(EXPORT robcl NAMESPACE robcl:: FILE robclTargets.cmake DESTINATION "${package_dir}")
install(EXPORT robclArm NAMESPACE robcl:: FILE robclArmTargets.cmake DESTINATION "${package_dir}")
install(EXPORT robclArmServer NAMESPACE robcl:: FILE robclArmServerTargets.cmake DESTINATION "${package_dir}")

set(idl "${PROJECT_SOURCE_DIR}/idl")
set(python "${PROJECT_SOURCE_DIR}/codegen")
set(lcm "${GECOS_LCM_LIBRARY}")
set(interpreter "set(Python_EXECUTABLE \"${Python_EXECUTABLE}\" CACHE FILEPATH \"Python with the requirements of robcl\")")
configure_package_config_file("${config}" "${PROJECT_BINARY_DIR}/robclConfig.cmake"
  INSTALL_PREFIX "${PROJECT_BINARY_DIR}" INSTALL_DESTINATION . PATH_VARS idl python lcm)
file(COPY ${parts} "${written}/robclConfigVersion.cmake" DESTINATION "${PROJECT_BINARY_DIR}")
export(EXPORT robcl NAMESPACE robcl:: FILE robclTargets.cmake)
export(EXPORT robclArm NAMESPACE robcl:: FILE robclArmTargets.cmake)
export(EXPORT robclArmServer NAMESPACE robcl:: FILE robclArmServerTargets.cmake)
