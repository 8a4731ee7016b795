# CLANG: the compiler; WRITE_PROGRAMS: the program that writes the programs for GPUs; FOLDER: their folder.
#
# Without optimisation clang calls every function that is not forced inline. C99's "inline" without "static" then only
# declares a function: there is no body to be called. Built-in functions are overloaded, and their names begin with _Z.
cmake_minimum_required(VERSION 3.25)

if(NOT CLANG)
  message("skipped: clang is not installed (on Debian: apt-get install clang)")
  return()
endif()

file(REMOVE_RECURSE ${FOLDER})
execute_process(COMMAND ${WRITE_PROGRAMS} ${FOLDER} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB programs ${FOLDER}/*.cl)
list(LENGTH programs count)
if(count LESS 40)
  message(FATAL_ERROR "only ${count} programs were written")
endif()
foreach(program IN LISTS programs)
  string(REGEX REPLACE "cl$" "options" options ${program})
  file(STRINGS ${options} options)
  separate_arguments(options)
  execute_process(
    COMMAND ${CLANG} -x cl ${options} -D__OPENCL_VERSION__=120 -target spir64 -Xclang -finclude-default-header -Xclang
            -fdeclare-opencl-builtins -O0 -S -emit-llvm -o - ${program}
    OUTPUT_VARIABLE code
    ERROR_VARIABLE log
    RESULT_VARIABLE status)
  if(NOT status EQUAL 0 OR NOT log STREQUAL "")
    message(SEND_ERROR "${program}: clang ended with ${status} and said\n${log}")
  endif()
  string(REGEX MATCHALL "define [^\n]*spir_kernel" kernels "${code}")
  if(NOT kernels)
    message(SEND_ERROR "${program} has no kernel")
  endif()
  string(REGEX MATCHALL "\ndeclare [^\n]*@[A-Za-z0-9_.]+" declared "${code}")
  list(TRANSFORM declared REPLACE "^.*@" "")
  list(FILTER declared EXCLUDE REGEX "^(_Z|llvm\\.)")
  if(declared)
    message(SEND_ERROR "${program}: functions without a body: ${declared}")
  endif()
endforeach()
message("${count} programs compiled without inlining")
