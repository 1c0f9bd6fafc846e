# gidl_generate(<target> <file.gidl>... [ROOT <dir>] [IMPORTS <dir>...])
#
# Makes the static library <target> of the C++ types, clients and servers of .gidl files of your own, to be linked by
# whoever includes them. ROOT is where your interfaces begin (default: the current source folder): a file
# <ROOT>/my/lamp.gidl gives "my/lamp_types.hpp", "my/lamp_client.hpp" and "my/lamp_server.hpp". What your files
# include is looked for below ROOT, below each of IMPORTS and in our own idl/ ("robcl/device.gidl").
#
# <target>_json is the library of their JSON, "my/lamp_json.hpp"; it is built where something links it.
#
# `gidl gen` runs when CMake configures, and CMake configures again when one of the files, what they include or gidl
# itself has changed.

get_filename_component(gecos_root "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
set(GECOS_ROOT "${gecos_root}" CACHE INTERNAL "The tree that holds idl/ and codegen/")

function(gidl_generate target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "ROOT" "IMPORTS")
  set(files ${arg_UNPARSED_ARGUMENTS})
  if(NOT files)
    message(FATAL_ERROR "gidl_generate(${target}): name at least one .gidl file")
  endif()
  if(NOT arg_ROOT)
    set(arg_ROOT "${CMAKE_CURRENT_SOURCE_DIR}")
  endif()
  get_filename_component(root "${arg_ROOT}" ABSOLUTE)
  find_package(Python 3.11 REQUIRED COMPONENTS Interpreter)

  set(out "${CMAKE_CURRENT_BINARY_DIR}/${target}")
  set(sources "")
  set(inputs "")
  foreach(file IN LISTS files)
    get_filename_component(input "${file}" ABSOLUTE)
    if(NOT EXISTS "${input}")
      message(FATAL_ERROR "gidl_generate(${target}): ${input} does not exist")
    endif()
    list(APPEND inputs "${input}")
  endforeach()

  set(search -I "${root}")
  foreach(directory IN LISTS arg_IMPORTS)
    get_filename_component(directory "${directory}" ABSOLUTE)
    list(APPEND search -I "${directory}")
  endforeach()
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${GECOS_ROOT}/codegen"
            "${Python_EXECUTABLE}" -m gidl gen --lang cpp ${search} -I "${GECOS_ROOT}/idl" --out "${out}"
            --depfile "${out}/inputs.d" ${inputs}
    OUTPUT_QUIET
    RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "gidl_generate(${target}): gidl gen failed; its findings are above")
  endif()
  file(READ "${out}/inputs.d" watched)
  string(REGEX REPLACE "^.*: \\\\\n" "" watched "${watched}")
  string(REGEX REPLACE " *\\\\?\n *" ";" watched "${watched}")
  string(REPLACE "\\ " " " watched "${watched}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${inputs} ${watched})

  file(GLOB_RECURSE sources "${out}/cpp/*.cpp")
  set(json_sources ${sources})
  list(FILTER sources EXCLUDE REGEX "_json\\.cpp$")
  list(FILTER json_sources INCLUDE REGEX "_json\\.cpp$")
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  target_include_directories(${target} PUBLIC "${out}/cpp")
  target_link_libraries(${target} PUBLIC robcl_generated gecos_session)
  if(json_sources)
    add_library(${target}_json STATIC EXCLUDE_FROM_ALL ${json_sources})
    target_link_libraries(${target}_json PUBLIC ${target} robcl_json)
  endif()
endfunction()
