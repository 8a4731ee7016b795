# SOURCE: the source tree.
#
# fmt before version 11 has fmt::join in its core header, later ones in fmt/ranges.h.
cmake_minimum_required(VERSION 3.25)

set(found 0)
foreach(folder lib apps tests benchmarks)
  file(GLOB_RECURSE sources ${SOURCE}/${folder}/*.[ch]pp)
  foreach(source ${sources})
    file(STRINGS ${source} joins REGEX "fmt::join")
    file(STRINGS ${source} includes REGEX "^#include <fmt/ranges\\.h>")
    if(joins AND NOT includes)
      message(SEND_ERROR "${source} uses fmt::join and does not include fmt/ranges.h")
    endif()
    if(joins)
      math(EXPR found "${found} + 1")
    endif()
  endforeach()
endforeach()
if(found LESS 10)
  message(SEND_ERROR "only ${found} files with fmt::join were found")
endif()
