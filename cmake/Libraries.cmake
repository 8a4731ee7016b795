# The settings that all libraries share, and the private headers that one may see of another.

# clsdf_part(<target> <part> <folder>): the objects of <part>, an object library, become those of <target>. The folder has the
# headers that <target>_internals shows of it.
function(clsdf_part target part folder)
  set_target_properties(${part} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_compile_definitions(${part} PRIVATE CLSDF_STATIC_BUILD)
  endif()
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:${part}>)
  set_property(TARGET ${target} APPEND PROPERTY CLSDF_PARTS ${part})
  set_property(TARGET ${target} APPEND PROPERTY CLSDF_PART_FOLDERS ${folder})
endfunction()

# clsdf_library(<target>): a shared library shows what its public headers mark with CLSDF_EXPORT, and nothing else; a static
# one shows nothing to the outside of the module that contains it.
function(clsdf_library target)
  set_target_properties(
    ${target}
    PROPERTIES CXX_VISIBILITY_PRESET hidden
               VISIBILITY_INLINES_HIDDEN ON
               VERSION ${PROJECT_VERSION}
               SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
               VERIFY_INTERFACE_HEADER_SETS ${PROJECT_IS_TOP_LEVEL})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_compile_definitions(${target} PRIVATE CLSDF_STATIC_BUILD)
  else()
    # Symbols of other libraries in ours (oneTBB's templates, the standard library's) are not for programs that link it.
    target_link_options(${target} PRIVATE LINKER:--exclude-libs,ALL)
  endif()
endfunction()

# clsdf_precompile(<target> [<header>...]): the headers that most files of the target include, compiled once. Headers of the
# project are not among them, since these change.
function(clsdf_precompile target)
  target_precompile_headers(
    ${target}
    PRIVATE
    <algorithm>
    <array>
    <atomic>
    <cmath>
    <cstdint>
    <functional>
    <map>
    <memory>
    <mutex>
    <optional>
    <ranges>
    <span>
    <string>
    <thread>
    <vector>
    <fmt/format.h>
    ${ARGN})
endfunction()

# clsdf_internals(<target> [FOLDERS <folder>...] [STATE_OF_PROCESS <source>...]): <target>_internals, for tests of what is
# inside a library and for the libraries beside it. Targets that link it see the library's own headers, those in the folders
# included. A static library has all the code. A shared one hides it; then its object files are also in a static library that
# is not installed. Link the library itself first, so that what it exports is taken from it.
#
# With shared libraries, a program may have several copies of a hidden function, and several of a variable. The sources
# STATE_OF_PROCESS have variables of which a process must have one. They are left out of the internals; their functions
# are marked CLSDF_EXPORT.
function(clsdf_internals target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FOLDERS;STATE_OF_PROCESS")
  set(internals ${target}_internals)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    add_library(${internals} INTERFACE)
    target_link_libraries(${internals} INTERFACE ${target})
  else()
    get_target_property(parts ${target} CLSDF_PARTS)
    if(NOT parts)
      set(parts ${target})
    endif()
    set(objects "")
    foreach(part IN LISTS parts)
      list(APPEND objects $<TARGET_OBJECTS:${part}>)
    endforeach()
    foreach(source IN LISTS arg_STATE_OF_PROCESS)
      string(REPLACE "." "\\." source ${source})
      set(objects $<FILTER:${objects},EXCLUDE,/${source}\\.>)
    endforeach()
    add_library(${internals} STATIC ${objects})
    set_target_properties(${internals} PROPERTIES LINKER_LANGUAGE CXX)
    # Targets that link it do not export its copies of the library's functions.
    target_link_options(${internals} INTERFACE LINKER:--exclude-libs,$<TARGET_FILE_NAME:${internals}>)
  endif()
  get_target_property(folders clsdf CLSDF_PART_FOLDERS)
  target_include_directories(
    ${internals} INTERFACE ${PROJECT_SOURCE_DIR}/lib ${folders} ${CLSDF_SHARED_KERNEL_FOLDERS} ${arg_FOLDERS}
                           $<TARGET_PROPERTY:clsdf_foundations,CLSDF_KERNEL_SOURCES>)
endfunction()
