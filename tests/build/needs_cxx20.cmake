# HEADERS: the folder of clsdf/; EIGEN: that of Eigen; COMPILER; SCRATCH: a directory of this test's own.
#
# Every public header, included first by a program that is compiled as C++17, ends the compilation with one sentence that
# says what to do: no error stands before it, and none but the missing file that stops the compiler comes after it.
cmake_minimum_required(VERSION 3.25)

file(GLOB headers RELATIVE ${HEADERS} ${HEADERS}/clsdf/*.hpp)
if(NOT headers)
  message(FATAL_ERROR "${HEADERS} has no public headers")
endif()
foreach(header IN LISTS headers)
  file(WRITE ${SCRATCH}/program.cpp "#include <${header}>\nint main() {}\n")
  execute_process(
    COMMAND ${COMPILER} -std=c++17 -fsyntax-only -I${HEADERS} -isystem ${EIGEN} ${SCRATCH}/program.cpp
    RESULT_VARIABLE status
    ERROR_VARIABLE log)
  string(REGEX MATCHALL "error: [^\n]*" errors "${log}")
  list(LENGTH errors count)
  if(status EQUAL 0)
    message(SEND_ERROR "${header} compiles as C++17")
  elseif(NOT count EQUAL 2 OR NOT "${errors}" MATCHES "^error: [^;]*clsdf needs C\\+\\+20: compile with -std=c\\+\\+20")
    message(SEND_ERROR "${header} does not say first, and alone, that it needs C++20:\n${log}")
  endif()
endforeach()
