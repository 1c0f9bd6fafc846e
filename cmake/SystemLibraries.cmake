# Libraries of the system and LCM's archive, as targets that ours name wherever they are used: in the tree, from a build
# folder and from an installed SDK. GECOS_LCM_LIBRARY is the path of liblcm.a. robcl_missing lists the libraries that were not found.
set(robcl_missing "")
function(gecos_imported target type location)
  if(NOT TARGET ${target})
    add_library(${target} ${type} IMPORTED)
  endif()
  set_target_properties(${target} PROPERTIES IMPORTED_LOCATION "${location}")
endfunction()

find_library(GECOS_SODIUM sodium)
if(NOT GECOS_SODIUM)
  string(APPEND robcl_missing "libsodium is missing: apt-get install libsodium-dev\n")
endif()
find_library(GECOS_GLIB NAMES libglib-2.0.so.0)
if(NOT GECOS_GLIB)
  string(APPEND robcl_missing "GLib's shared library is missing: apt-get install libglib2.0-0\n")
endif()
find_path(GECOS_EXPECTED tl/expected.hpp)
if(NOT GECOS_EXPECTED)
  string(APPEND robcl_missing "tl/expected.hpp is missing: apt-get install libexpected-dev\n")
endif()

gecos_imported(robcl::sodium UNKNOWN "${GECOS_SODIUM}")
gecos_imported(robcl::glib SHARED "${GECOS_GLIB}")
# None of LCM's symbols leaves a binary, so that one process may also `import lcm`.
gecos_imported(robcl::lcm STATIC "${GECOS_LCM_LIBRARY}")
set_target_properties(robcl::lcm PROPERTIES
  INTERFACE_LINK_LIBRARIES "robcl::glib;Threads::Threads"
  INTERFACE_LINK_OPTIONS "LINKER:--exclude-libs,liblcm.a")
