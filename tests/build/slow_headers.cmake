# SOURCE: the source tree.
#
# CLI11 and nlohmann's JSON take seconds to compile, so few files of the command include them.
cmake_minimum_required(VERSION 3.25)

set(found "")
file(GLOB sources ${SOURCE}/apps/clsdf/*.[ch]pp ${SOURCE}/benchmarks/*.[ch]pp)
foreach(source ${sources})
  file(STRINGS ${source} includes REGEX "^#include <(CLI|nlohmann)/")
  if(includes)
    cmake_path(GET source FILENAME name)
    list(APPEND found ${name})
  endif()
endforeach()
if(NOT found STREQUAL "json.cpp;options.cpp;scene_file.cpp")
  message(SEND_ERROR "CLI11 and nlohmann's JSON are included by ${found}; options.cpp, json.cpp and scene_file.cpp alone may include them")
endif()
