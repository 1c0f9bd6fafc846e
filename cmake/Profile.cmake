# GECOS_PROFILE=record builds programs that write down, when they end, how often each branch was taken; GECOS_PROFILE=use,
# later in the same build folder, builds by what they wrote. tools/build_release.sh does one after the other.
if(NOT GECOS_PROFILE STREQUAL "" AND NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  message(FATAL_ERROR "GECOS_PROFILE speaks GCC's options, and the compiler is ${CMAKE_CXX_COMPILER_ID}: leave it out.")
endif()
set(profile "${PROJECT_BINARY_DIR}/profile")
if(GECOS_PROFILE STREQUAL "record")
  add_compile_options("-fprofile-generate=${profile}" -fprofile-update=atomic)
  add_link_options("-fprofile-generate=${profile}")
elseif(GECOS_PROFILE STREQUAL "use")
  # What was not run is optimised as it would be without; counts of several threads need not add up.
  add_compile_options("-fprofile-use=${profile}" -fprofile-partial-training -fprofile-correction -Wno-missing-profile)
elseif(NOT GECOS_PROFILE STREQUAL "")
  message(FATAL_ERROR "GECOS_PROFILE is '${GECOS_PROFILE}'; it may be empty, 'record' or 'use'.")
endif()
