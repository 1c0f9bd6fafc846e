# Installs the headers that programs and generated code include, and those of ours that these include, and no other. It
# runs when something is installed, so that it sees the files as they are then. tree: the folder of this project.
cmake_policy(VERSION 3.22)
set(include_folders "${tree}/runtime/cpp" "${tree}/generated/cpp" "${tree}")

# The headers of ours that a file includes.
function(included_by file result)
  file(STRINGS "${file}" lines REGEX "^ *# *include *\"")
  list(TRANSFORM lines REPLACE "^[^\"]*\"([^\"]*)\".*$" "\\1")
  set(${result} "${lines}" PARENT_SCOPE)
endfunction()

set(todo devices/arm/arm_program.hpp)  # for programs that serve an arm
foreach(folder IN LISTS include_folders)
  file(GLOB public RELATIVE "${folder}"
    "${folder}/gecos/*.hpp" "${folder}/gecos/wire/json.hpp" "${folder}/robcl/*.hpp" "${folder}/robcl/*/*.hpp")
  list(APPEND todo ${public})
endforeach()
list(REMOVE_ITEM todo gecos/binding.hpp)  # for the binding of Python and for tests
file(GLOB_RECURSE templates "${tree}/codegen/gidl/targets/*pp.j2")
foreach(template IN LISTS templates)
  included_by("${template}" headers)
  list(APPEND todo ${headers})
endforeach()

set(done "")
while(todo)
  list(POP_FRONT todo header)
  if(header IN_LIST done)
    continue()
  endif()
  list(APPEND done "${header}")
  foreach(folder IN LISTS include_folders)
    if(EXISTS "${folder}/${header}")
      get_filename_component(below "${header}" DIRECTORY)
      file(INSTALL "${folder}/${header}" DESTINATION "${CMAKE_INSTALL_PREFIX}/include/${below}")
      included_by("${folder}/${header}" headers)
      list(APPEND todo ${headers})
    endif()
  endforeach()
endwhile()
