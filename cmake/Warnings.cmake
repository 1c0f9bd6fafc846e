# The warnings that our own code is free of, under g++ 12 and 14 and clang 14 and 19.
set(GECOS_WARNINGS -Wall -Wextra -Wconversion -Wshadow)
if(GECOS_WERROR)
  list(APPEND GECOS_WARNINGS -Werror)
endif()
