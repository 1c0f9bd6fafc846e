# The warnings that our own code is free of, under g++ 12 and clang-14.
set(GECOS_WARNINGS -Wall -Wextra -Wconversion -Wshadow)
if(GECOS_WERROR)
  list(APPEND GECOS_WARNINGS -Werror)
endif()
