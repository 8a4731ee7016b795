# Run by clsdf_embed_kernels: INPUTS (a list of files) -> OUTPUT (a header with a string for every file).
#
# A text is only ever handled as one quoted argument: as a list, CMake would split it at semicolons and join it at
# brackets. It becomes ordinary literals, one a line: in raw ones GCC 12 alters blanks that follow a backslash.
cmake_minimum_required(VERSION 3.25)

set(constants "")
set(table "")
set(names "")
foreach(input IN LISTS INPUTS)
  get_filename_component(file_name "${input}" NAME)
  get_filename_component(name "${input}" NAME_WE)
  if(NOT name MATCHES "^[A-Za-z_][A-Za-z0-9_]*$")
    message(FATAL_ERROR "${input}: the name of a kernel file must be an identifier with an ending")
  endif()
  if(name IN_LIST names)
    message(FATAL_ERROR "${input}: another kernel file is called ${name}; they would be the same constant")
  endif()
  list(APPEND names ${name})

  file(READ "${input}" text)
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "\"" "\\\"" text "${text}")
  string(REPLACE "\r" "\\r" text "${text}")
  string(REPLACE "\n" "\\n\"\n    \"" text "${text}")
  string(APPEND constants "\ninline constexpr std::string_view ${name} =\n    \"${text}\";\n")
  string(APPEND table "    File{\"${file_name}\", ${name}},\n")
endforeach()

file(WRITE "${OUTPUT}" "#pragma once

// Made from kernels/ by the build. No warnings: the standard promises literals of 65,536 characters only.
#pragma GCC system_header

#include <string_view>

namespace clsdf::kernels {

struct File {
    std::string_view name;
    std::string_view text;
};
${constants}
inline constexpr File files[] = {
${table}};

}  // namespace clsdf::kernels
")
