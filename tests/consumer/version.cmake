# SOURCES_VERSION: the minor version of these sources, as a project that uses clsdf asks for it: 0.1.
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/../../lib/include/clsdf/version.hpp lines REGEX "^#define CLSDF_VERSION_(MAJOR|MINOR) ")
string(REGEX REPLACE "#define CLSDF_VERSION_(MAJOR|MINOR) " "" SOURCES_VERSION "${lines}")
list(JOIN SOURCES_VERSION "." SOURCES_VERSION)
