# gidl_generate(<target> <file.gidl>... [ROOT <dir>] [IMPORTS <dir>...])
#
# Makes the static library <target> of the C++ types, clients and servers of .gidl and .idl files of your own, to be
# linked by the programs that include them. ROOT is where your interfaces begin (default: the current source folder):
# <ROOT>/my/lamp.gidl gives "my/lamp_types.hpp", "my/lamp_interface.hpp", "my/lamp_client.hpp" and "my/lamp_server.hpp". What your files
# include is looked for below ROOT, below each of IMPORTS and in our own idl/ ("robcl/device.gidl").
#
# What your files include from IMPORTS is generated too, once for the whole build: <target> links the target that an
# earlier gidl_generate made of such a file, or else <target>_imports, which is made here. Included files below ROOT are
# for another gidl_generate, whose target you link; a file that none of them names is an error at the end of configuring.
#
# <target>_json is the library of their JSON, "my/lamp_json.hpp"; it is built where something links it.
#
# `gidl gen` runs in ROOT when CMake configures, and so heeds a gidl.toml there or above. CMake configures again when
# one of the files, what they include, gidl.toml or gidl itself has changed.

# robclConfig.cmake says where our interfaces and the Python package gidl are; in the tree they are beside this folder.
if(NOT robcl_idl)
  get_filename_component(robcl_idl "${CMAKE_CURRENT_LIST_DIR}/../idl" ABSOLUTE)
  get_filename_component(robcl_python "${CMAKE_CURRENT_LIST_DIR}/../codegen" ABSOLUTE)
endif()
set(GECOS_IDL "${robcl_idl}" CACHE INTERNAL "Folder of our own interfaces")
set(GECOS_PYTHON "${robcl_python}" CACHE INTERNAL "Folder of the Python package gidl")

function(gidl_generate target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "ROOT" "IMPORTS")
  set(files ${arg_UNPARSED_ARGUMENTS})
  if(NOT files)
    message(FATAL_ERROR "gidl_generate(${target}): no file is named; name at least one .gidl or .idl file")
  endif()
  set(without_root FALSE)
  if(NOT arg_ROOT)
    set(without_root TRUE)
    set(arg_ROOT "${CMAKE_CURRENT_SOURCE_DIR}")
  endif()
  get_filename_component(root "${arg_ROOT}" ABSOLUTE)
  if(NOT IS_DIRECTORY "${root}")
    message(FATAL_ERROR "gidl_generate(${target}): ROOT ${root} is no folder; name the folder where your includes begin")
  endif()
  set(inputs "")
  foreach(file IN LISTS files)
    get_filename_component(input "${file}" ABSOLUTE)
    if(NOT EXISTS "${input}")
      message(FATAL_ERROR "gidl_generate(${target}): ${input} does not exist; name files from the folder "
                          "${CMAKE_CURRENT_SOURCE_DIR}, not from ROOT")
    endif()
    if(without_root)
      gecos_gidl_warn_of_root(${target} "${input}" "${root}")
    endif()
    list(APPEND inputs "${input}")
  endforeach()
  set(imports "")
  foreach(directory IN LISTS arg_IMPORTS)
    get_filename_component(directory "${directory}" ABSOLUTE)
    list(APPEND imports "${directory}")
  endforeach()
  gecos_gidl_library(${target} "${inputs}" "${root}" "${imports}")
endfunction()

# Interfaces usually lie in a folder idl/, where their includes and those of their headers begin.
function(gecos_gidl_warn_of_root target input root)
  file(RELATIVE_PATH name "${root}" "${input}")
  if(name MATCHES "^((.*/)?idl)/(.+)\\.[a-z]+$")
    message(WARNING "gidl_generate(${target}): the client's header is \"${CMAKE_MATCH_1}/${CMAKE_MATCH_3}_client.hpp\"; to "
                    "include \"${CMAKE_MATCH_3}_client.hpp\", add: ROOT ${CMAKE_MATCH_1}")
  endif()
endfunction()

# The library of `inputs`, and before it the one of what they import.
function(gecos_gidl_library target inputs root imports)
  gecos_gidl_claim(${target} "${inputs}" "${root}" "${imports}")
  gecos_gidl_run(${target} "${inputs}" "${root}" "${imports}" interfaces)
  set(makers "")
  set(unmade "")
  foreach(file IN LISTS interfaces)
    if(file IN_LIST inputs)
      continue()
    endif()
    gecos_gidl_kind("${file}" "${root}" "${imports}" kind)
    if(kind STREQUAL "OWN")  # a later gidl_generate may make this file, so it is looked for at the end of configuring
      cmake_language(EVAL CODE
        "cmake_language(DEFER DIRECTORY [[${CMAKE_SOURCE_DIR}]] CALL gecos_gidl_check_maker [[${target}]] [[${file}]])")
    endif()
    if(NOT kind STREQUAL "IMPORT")
      continue()
    endif()
    get_property(maker GLOBAL PROPERTY "gidl maker of ${file}")
    if(maker)
      gecos_gidl_same_name(${target} ${maker} "${file}" "${root}" "${imports}")
      list(APPEND makers ${maker})
    else()
      list(APPEND unmade "${file}")
    endif()
  endforeach()
  if(unmade)
    gecos_gidl_library(${target}_imports "${unmade}" "${root}" "${imports}")
    foreach(file IN LISTS unmade)
      set_property(GLOBAL PROPERTY "gidl importer of ${file}" ${target})
    endforeach()
    list(APPEND makers ${target}_imports)
  endif()
  list(REMOVE_DUPLICATES makers)

  set(out "${CMAKE_CURRENT_BINARY_DIR}/${target}")
  file(GLOB_RECURSE sources "${out}/cpp/*.cpp")
  set(json_sources ${sources})
  list(FILTER sources EXCLUDE REGEX "_json\\.cpp$")
  list(FILTER json_sources INCLUDE REGEX "_json\\.cpp$")
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  target_include_directories(${target} PUBLIC "${out}/cpp")
  target_link_libraries(${target} PUBLIC ${makers} robcl::generated robcl::gecos_session)
  if(json_sources)
    add_library(${target}_json STATIC EXCLUDE_FROM_ALL ${json_sources})
    target_link_libraries(${target}_json PUBLIC ${target} robcl::json)
    foreach(maker IN LISTS makers)
      if(TARGET ${maker}_json)
        target_link_libraries(${target}_json PUBLIC ${maker}_json)
      endif()
    endforeach()
  endif()
endfunction()

# Runs gidl, and gives the interface files that it read.
function(gecos_gidl_run target inputs root imports result)
  find_package(Python 3.11 REQUIRED COMPONENTS Interpreter)
  set(out "${CMAKE_CURRENT_BINARY_DIR}/${target}")
  set(search "")
  foreach(directory IN LISTS root imports ITEMS "${GECOS_IDL}")
    list(APPEND search -I "${directory}")
  endforeach()
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${GECOS_PYTHON}"
            "${Python_EXECUTABLE}" -m gidl gen --prune --lang cpp ${search} --out "${out}"
            --depfile "${out}/inputs.d" ${inputs}
    WORKING_DIRECTORY "${root}"
    OUTPUT_QUIET
    RESULT_VARIABLE failed)
  if(failed)
    gecos_gidl_failed(${target})
  endif()
  file(READ "${out}/inputs.d" read)
  string(REGEX REPLACE "^.*: \\\\\n" "" read "${read}")
  string(REGEX REPLACE " *\\\\?\n *" ";" read "${read}")
  string(REPLACE "\\ " " " read "${read}")
  list(TRANSFORM read STRIP)
  list(FILTER read EXCLUDE REGEX "^$")
  set(watched "")
  foreach(file IN LISTS read)
    get_filename_component(file "${file}" ABSOLUTE BASE_DIR "${root}")
    list(APPEND watched "${file}")
  endforeach()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${inputs} ${watched})
  list(FILTER watched INCLUDE REGEX "\\.[gG]?[iI][dD][lL]$")
  set(${result} "${watched}" PARENT_SCOPE)
endfunction()

function(gecos_gidl_failed target)
  execute_process(COMMAND "${Python_EXECUTABLE}" -c "import jinja2" RESULT_VARIABLE lacks_jinja2 OUTPUT_QUIET ERROR_QUIET)
  if(lacks_jinja2)
    message(FATAL_ERROR "gidl_generate(${target}): gidl needs jinja2, which ${Python_EXECUTABLE} does not have: apt-get "
                        "install python3-jinja2, or name an interpreter that has it by -DPython_EXECUTABLE=<path>")
  endif()
  message(FATAL_ERROR "gidl_generate(${target}): gidl gen failed; its findings are above")
endfunction()

# Notes that `target` makes these files, for those who import them later.
function(gecos_gidl_claim target inputs root imports)
  foreach(file IN LISTS inputs)
    get_property(importer GLOBAL PROPERTY "gidl importer of ${file}")
    if(importer)
      message(FATAL_ERROR "gidl_generate(${target}): ${file} was generated already for ${importer}, which imports it; "
                          "call gidl_generate(${target}) before gidl_generate(${importer})")
    endif()
    get_property(maker GLOBAL PROPERTY "gidl maker of ${file}")
    if(NOT maker)
      gecos_gidl_name("${file}" "${root}" "${imports}" name)
      set_property(GLOBAL PROPERTY "gidl maker of ${file}" ${target})
      set_property(GLOBAL PROPERTY "gidl name of ${file}" "${name}")
    endif()
  endforeach()
endfunction()

function(gecos_gidl_check_maker target file)
  get_property(maker GLOBAL PROPERTY "gidl maker of ${file}")
  if(NOT maker)
    message(FATAL_ERROR "gidl_generate(${target}): nothing makes the headers of ${file}, which a file of ${target} includes; "
                        "name it in gidl_generate(${target}), or in another gidl_generate whose target you link")
  endif()
endfunction()

# Headers of one file have one name in a build.
function(gecos_gidl_same_name target maker file root imports)
  get_property(there GLOBAL PROPERTY "gidl name of ${file}")
  gecos_gidl_name("${file}" "${root}" "${imports}" here)
  if(NOT here STREQUAL there)
    message(FATAL_ERROR "gidl_generate(${target}): ${file} is ${here} here and ${there} for ${maker}; "
                        "let both find it from the same folder, as ROOT or IMPORTS")
  endif()
endfunction()

# What a file is called where includes begin.
function(gecos_gidl_name file root imports result)
  get_filename_component(name "${file}" NAME)
  foreach(directory IN LISTS root imports)
    cmake_path(IS_PREFIX directory "${file}" NORMALIZE below)
    if(below)
      file(RELATIVE_PATH name "${directory}" "${file}")
      break()
    endif()
  endforeach()
  set(${result} "${name}" PARENT_SCOPE)
endfunction()

# Who makes the headers of an included file. OURS: they are in robcl_generated. IMPORT: it comes from IMPORTS, or from
# outside ROOT, so gidl_generate itself makes them. OWN: another gidl_generate.
function(gecos_gidl_kind file root imports result)
  cmake_path(IS_PREFIX root "${file}" NORMALIZE own)
  set(kind IMPORT)
  if(own)
    set(kind OWN)
  endif()
  foreach(directory IN LISTS imports)
    cmake_path(IS_PREFIX directory "${file}" NORMALIZE below)
    if(below)
      set(kind IMPORT)
    endif()
  endforeach()
  foreach(ours "${GECOS_IDL}" "${GECOS_PYTHON}")
    cmake_path(IS_PREFIX ours "${file}" NORMALIZE below)
    if(below)
      set(kind OURS)
    endif()
  endforeach()
  set(${result} ${kind} PARENT_SCOPE)
endfunction()
