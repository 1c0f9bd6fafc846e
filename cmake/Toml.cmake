# ROBCL_TOMLPLUSPLUS is the folder of toml++. It is used as headers alone, in sources alone, so that neither programs nor
# users of the SDK need it.
find_path(ROBCL_TOMLPLUSPLUS toml++/toml.h)
if(NOT ROBCL_TOMLPLUSPLUS)
  message(FATAL_ERROR "toml++/toml.h is missing: apt-get install libtomlplusplus-dev")
endif()
