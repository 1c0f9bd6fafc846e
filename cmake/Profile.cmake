# GECOS_PROFILE=record builds programs that write down, when they end, how often each branch was taken;
# GECOS_PROFILE=use builds by what they wrote into GECOS_PROFILE_DIR. tools/build_release.sh does one after the other.
if(NOT GECOS_PROFILE STREQUAL "" AND NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  message(FATAL_ERROR "GECOS_PROFILE speaks GCC's options, and the compiler is ${CMAKE_CXX_COMPILER_ID}: leave it out.")
endif()
# Names of what is written are those of the object files below the build folder, the same in both builds.
set(where "-fprofile-prefix-path=${PROJECT_BINARY_DIR}")
if(GECOS_PROFILE STREQUAL "record")
  add_compile_options("-fprofile-generate=${GECOS_PROFILE_DIR}" -fprofile-update=atomic "${where}")
  add_link_options("-fprofile-generate=${GECOS_PROFILE_DIR}")
elseif(GECOS_PROFILE STREQUAL "use")
  # What was not run is optimised as it would be without; counts of several threads need not add up.
  add_compile_options("-fprofile-use=${GECOS_PROFILE_DIR}" "${where}" -fprofile-partial-training
                      -fprofile-correction -Wno-missing-profile)
elseif(NOT GECOS_PROFILE STREQUAL "")
  message(FATAL_ERROR "GECOS_PROFILE is '${GECOS_PROFILE}'; it may be empty, 'record' or 'use'.")
endif()
