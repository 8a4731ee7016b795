# SOURCE: the source tree.
#
# Only one kernel file, simd.h, names instruction sets and built-in functions of compilers.
cmake_minimum_required(VERSION 3.25)

set(names "__builtin_|__has_builtin|__clang__|__AVX|__SSE|__x86|__aarch")
file(GLOB_RECURSE files ${SOURCE}/kernels/*.cl ${SOURCE}/kernels/*.h)
list(REMOVE_ITEM files ${SOURCE}/kernels/common/simd.h)
foreach(file ${files})
  file(STRINGS ${file} lines REGEX "${names}")
  foreach(line IN LISTS lines)
    message(SEND_ERROR "${file}: ${line}\nmove it to kernels/common/simd.h")
  endforeach()
endforeach()
list(LENGTH files count)
if(count LESS 40)
  message(SEND_ERROR "only ${count} kernel files were found")
endif()
file(STRINGS ${SOURCE}/kernels/common/simd.h lines REGEX "${names}")
if(NOT lines)
  message(SEND_ERROR "simd.h names none of ${names}")
endif()
