# Run by clsdf_embed_kernels: INPUTS (a list of files) -> OUTPUT (a header with the text of every file).
#
# A text is only ever handled as one quoted argument: as a list, CMake would split it at semicolons and join it at
# brackets. It becomes ordinary literals, one a line: in raw ones GCC 12 alters blanks that follow a backslash. Their
# suffix gives the length, which clang would otherwise count in more steps than it allows a constant.
cmake_minimum_required(VERSION 3.25)

set(table "")
foreach(input IN LISTS INPUTS)
  get_filename_component(name "${input}" NAME)
  file(READ "${input}" text)
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "\"" "\\\"" text "${text}")
  string(REPLACE "\r" "\\r" text "${text}")
  string(REPLACE "\n" "\\n\"\n     \"" text "${text}")
  string(APPEND table "\n    {\"${name}\",\n     \"${text}\"sv},\n")
endforeach()

file(WRITE "${OUTPUT}" "#pragma once

// Made from kernels/ by the build. No warnings: the standard promises literals of 65,536 characters only.
#pragma GCC system_header

#include \"device/context.hpp\"

namespace clsdf::kernels {

using namespace std::string_view_literals;

// The kernel files of this library; other libraries have their own.
constexpr device::KernelFile files[] = {
${table}};

}  // namespace clsdf::kernels
")
