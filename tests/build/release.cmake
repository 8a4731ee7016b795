# CLSDF: the sources; SCRATCH: a directory of this test's own.
#
# scripts/release makes the commit, the tag and the source archive of a version in a clone, and leaves the folder that it is
# called in as it was. Here that is a small repository with the files that it reads, and a change log of known contents.
cmake_minimum_required(VERSION 3.25)
find_program(git git)
if(NOT git)
  message("skipped: git is not installed")
  return()
endif()

set(tree "${SCRATCH}/a tree")
file(REMOVE_RECURSE "${SCRATCH}")
foreach(file CITATION.cff .gitattributes .gitignore scripts/common.bash scripts/release lib/include/clsdf/version.hpp
             bindings/python/pyproject.toml packaging/vcpkg/vcpkg.json packaging/conda/recipe.yaml
             apps/clsdf/archived_commit.txt apps/clsdf/write_commit.cmake)
  get_filename_component(folder "${tree}/${file}" DIRECTORY)
  file(COPY "${CLSDF}/${file}" DESTINATION "${folder}")
endforeach()
file(WRITE "${tree}/CHANGELOG.md" "# Changelog

## [Unreleased]

### Fixed
- A fault.

### Files and bytes until 0.9.1
No file.
- Of one commit.

### Files and bytes
- Of files.

## [0.0.9] - 2020-01-01

### Fixed
- An earlier one.
")

# in(<folder> <result> <command>...): the output of a command that must succeed.
function(in folder result)
  execute_process(
    COMMAND ${ARGN}
    WORKING_DIRECTORY "${folder}"
    OUTPUT_VARIABLE output
    ERROR_VARIABLE errors
    RESULT_VARIABLE status
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN} ends with ${status}: ${output}${errors}")
  endif()
  set(${result} "${output}" PARENT_SCOPE)
endfunction()
# refused(<message> <argument>...)
function(refused message)
  execute_process(
    COMMAND "${tree}/scripts/release" ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(status EQUAL 0 OR NOT output MATCHES "${message}")
    message(SEND_ERROR "release ${ARGN} ends with ${status}: ${output}")
  endif()
endfunction()

set(ENV{GIT_CONFIG_GLOBAL} /dev/null)
in("${tree}" output git init -q)
in("${tree}" output git add -A)
in("${tree}" output git -c user.name=Somebody -c user.email=somebody@example.org commit -q -m "The tree")
in("${tree}" head git rev-parse HEAD)

refused("scripts/release VERSION" 0.9)
file(WRITE "${tree}/left" "")
refused("the folder has changes" 0.9.1)
file(REMOVE "${tree}/left")

in("${tree}" output "${tree}/scripts/release" 0.9.1 archive)
if(NOT output MATCHES "Nothing is published")
  message(SEND_ERROR "release says: ${output}")
endif()
in("${tree}" output git status --porcelain)
in("${tree}" now git rev-parse HEAD)
in("${tree}" tags git tag)
if(output OR tags OR NOT now STREQUAL head)
  message(SEND_ERROR "the folder has changed: ${output}${tags}")
endif()

# The commit.
set(release "${tree}/build/0.9.1")
in("${release}/clone" commit git rev-parse "v0.9.1^{commit}")
in("${release}/clone" parent git rev-parse "v0.9.1^")
in("${release}/clone" date git log -1 --format=%cs HEAD)
if(NOT parent STREQUAL head)
  message(SEND_ERROR "v0.9.1 is no child of ${head}")
endif()
file(READ "${release}/clone/CHANGELOG.md" changes)
if(NOT changes STREQUAL "# Changelog

## [Unreleased]

## [0.9.1] - ${date}

### Fixed
- A fault.

### Files and bytes
- Of files.

## [0.0.9] - 2020-01-01

### Fixed
- An earlier one.
")
  message(SEND_ERROR "CHANGELOG.md is ${changes}")
endif()

# The archive: the version, and the commit that the command prints.
file(ARCHIVE_EXTRACT INPUT "${release}/files/clsdf-0.9.1.tar.gz" DESTINATION "${SCRATCH}")
set(archived "${SCRATCH}/clsdf-0.9.1")
file(READ "${archived}/lib/include/clsdf/version.hpp" header)
file(READ "${archived}/bindings/python/pyproject.toml" project)
file(READ "${archived}/CITATION.cff" citation)
file(READ "${archived}/packaging/vcpkg/vcpkg.json" port)
file(READ "${archived}/packaging/conda/recipe.yaml" recipe)
if(NOT header MATCHES "MAJOR 0\n#define CLSDF_VERSION_MINOR 9\n#define CLSDF_VERSION_PATCH 1\n"
   OR NOT project MATCHES "\nversion = \"0.9.1\"" OR NOT citation MATCHES "\nversion: 0.9.1\ndate-released: ${date}\n"
   OR NOT port MATCHES "\"version\": \"0.9.1\"" OR NOT recipe MATCHES "  version: \"0.9.1\"\n")
  message(SEND_ERROR "the archive has another version: ${header}${project}${citation}${port}${recipe}")
endif()
in("${SCRATCH}" output ${CMAKE_COMMAND} "-DSOURCE=${archived}" "-DOUTPUT=${SCRATCH}/commit.hpp" -P "${archived}/apps/clsdf/write_commit.cmake")
file(READ "${SCRATCH}/commit.hpp" header)
string(SUBSTRING "${commit}" 0 12 commit)
if(NOT header MATCHES "CLSDF_COMMIT \"${commit}\"" OR NOT header MATCHES "CLSDF_DATE \"${date}\"")
  message(SEND_ERROR "the archive of ${commit}, ${date}, says: ${header}")
endif()
in("${release}/files" output sha256sum --check SHA256SUMS)
