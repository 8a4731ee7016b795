# clsdf_warnings: the warnings that our own targets are compiled with. They are errors in our presets only: a newer
# compiler, which warns of more, must not stop a user's build.
option(CLSDF_WARNINGS_AS_ERRORS "Treat a compiler's warning as an error" OFF)

add_library(clsdf_warnings INTERFACE)
target_compile_options(
  clsdf_warnings
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wconversion
            -Wsign-conversion
            -Wold-style-cast
            -Wnon-virtual-dtor
            -Woverloaded-virtual
            -Wdouble-promotion
            -Wformat=2)
if(CLSDF_WARNINGS_AS_ERRORS)
  target_compile_options(clsdf_warnings INTERFACE -Werror)
endif()
