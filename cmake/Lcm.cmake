# Imports LCM's static library from the PyPI wheel `lcm` as the targets `lcm-static` and `robcl::lcm`.
#
# Debian's liblcm 1.3.1 can be crashed by two malformed datagrams; the wheel's 1.5.3 survives them, and it is the
# same version that Python imports. The wheel is found through the interpreter given by -DPython_EXECUTABLE (as
# `make build` does, with the one in .venv) or in the folder given by -DLCM_WHEEL_DIR (a site-packages folder).

set(LCM_WHEEL_DIR "" CACHE PATH "site-packages folder that holds the PyPI wheel lcm (default: ask Python_EXECUTABLE)")

set(gecos_lcm_dir "${LCM_WHEEL_DIR}")
if(NOT gecos_lcm_dir)
  if(NOT Python_EXECUTABLE AND EXISTS "${PROJECT_SOURCE_DIR}/.venv/bin/python")
    set(Python_EXECUTABLE "${PROJECT_SOURCE_DIR}/.venv/bin/python" CACHE FILEPATH "Python with our requirements")
  endif()
  find_package(Python 3.11 REQUIRED COMPONENTS Interpreter)
  execute_process(
    COMMAND "${Python_EXECUTABLE}" -c
            "import importlib.metadata as m; print(m.distribution('lcm').locate_file(''))"
    OUTPUT_VARIABLE gecos_lcm_dir
    OUTPUT_STRIP_TRAILING_WHITESPACE
    RESULT_VARIABLE gecos_lcm_missing
    ERROR_QUIET)
  if(gecos_lcm_missing)
    message(FATAL_ERROR
      "The Python package lcm, whose C++ library we link, is not installed for ${Python_EXECUTABLE}.\n"
      "Run `make setup` and configure with -DPython_EXECUTABLE=.venv/bin/python, or name a folder that holds it "
      "with -DLCM_WHEEL_DIR=<site-packages>.")
  endif()
endif()

# The wheel's configuration names GLib2::glib without looking for it, and only its shared library is needed.
if(NOT TARGET GLib2::glib)
  find_library(GECOS_GLIB NAMES libglib-2.0.so.0 REQUIRED)
  add_library(GLib2::glib SHARED IMPORTED GLOBAL)
  set_target_properties(GLib2::glib PROPERTIES IMPORTED_LOCATION "${GECOS_GLIB}")
endif()

find_package(lcm 1.5.3 CONFIG REQUIRED PATHS "${gecos_lcm_dir}/lib/lcm/cmake" NO_DEFAULT_PATH)

# Exported targets name robcl::lcm, which SystemLibraries.cmake defines wherever they are used.
get_target_property(GECOS_LCM_LIBRARY lcm-static LOCATION)
include(SystemLibraries)
if(robcl_missing)
  message(FATAL_ERROR "${robcl_missing}Or run tools/setup.sh build.")
endif()
foreach(property INTERFACE_COMPILE_DEFINITIONS INTERFACE_INCLUDE_DIRECTORIES)
  get_target_property(value lcm-static ${property})
  set_property(TARGET robcl::lcm PROPERTY ${property} "${value}")
endforeach()
