# SOURCE: the source tree.
#
# A folder of the core includes only files of folders before it in the order in which lib/CMakeLists.txt names them, so
# no folders include each other.
cmake_minimum_required(VERSION 3.25)

file(READ ${SOURCE}/lib/CMakeLists.txt list)
string(REGEX MATCH "foreach\\(folder ([a-z ]+)\\)" whole "${list}")
string(REPLACE " " ";" folders "${CMAKE_MATCH_1}")
set(allowed "")
set(found 0)
foreach(folder ${folders})
  list(APPEND allowed ${folder})
  file(GLOB sources ${SOURCE}/lib/${folder}/*.[ch]pp)
  foreach(source ${sources})
    file(STRINGS ${source} includes REGEX "^#include \"[a-z]+/")
    foreach(include ${includes})
      string(REGEX MATCH "\"([a-z]+)/" whole "${include}")
      if(NOT CMAKE_MATCH_1 IN_LIST allowed)
        message(SEND_ERROR "${source}: ${include}\nlib/${folder} may include files of these folders only: ${allowed}")
      endif()
      math(EXPR found "${found} + 1")
    endforeach()
  endforeach()
endforeach()
if(found LESS 100)
  message(SEND_ERROR "only ${found} includes were found")
endif()
