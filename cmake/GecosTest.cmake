# gecos_test(<name> [COMPUTES] SOURCES <file>... [LIBRARIES <target>...])
#
# A GoogleTest binary whose every TEST becomes a ctest of its own, named <name>.<Suite>.<Test>.
# Each gets 60 s before it is killed, under a sanitizer 300: a test that hangs is a test that failed.
# Most tests wait most of the time, so `make test` runs two of them for each core. A program that COMPUTES is optimised,
# and each of its tests counts as two. Under a sanitizer one test runs for each core, and each counts as one.
function(gecos_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "COMPUTES" "" "SOURCES;LIBRARIES")
  if(NOT arg_SOURCES OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "gecos_test(${name}): write gecos_test(<name> SOURCES <file>... LIBRARIES <target>...)")
  endif()
  add_executable(${name} ${arg_SOURCES})
  list(LENGTH arg_SOURCES files)
  if(files GREATER 1)  # their headers, most of the work, are read once for eight of them
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON)
    set(replaces_new ${arg_SOURCES})  # which must not be seen by who calls it, or is inlined there
    list(FILTER replaces_new INCLUDE REGEX "allocations\\.cpp$")
    set_source_files_properties(${replaces_new} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  set(longest 60)
  if(GECOS_SANITIZE)
    set(longest 300)
  endif()
  set(slots 1)
  if(arg_COMPUTES)
    target_compile_options(${name} PRIVATE -O2)
    if(NOT GECOS_SANITIZE)
      set(slots 2)
    endif()
  elseif(NOT GECOS_SANITIZE)
    target_compile_options(${name} PRIVATE -O0)  # compiled a third faster; what it tests is optimised
  endif()
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} GTest::gtest_main Threads::Threads)
  include(GoogleTest)
  gtest_discover_tests(${name} TEST_PREFIX "${name}."
                        PROPERTIES TIMEOUT ${longest} PROCESSORS ${slots} ENVIRONMENT "GECOS_KEY_DIR=${CMAKE_BINARY_DIR}/tests/keys"
                                   ENVIRONMENT_MODIFICATION "GECOS_AUDIT_DIR=set:${CMAKE_BINARY_DIR}/tests/audit"
                        DISCOVERY_TIMEOUT 60)
endfunction()
