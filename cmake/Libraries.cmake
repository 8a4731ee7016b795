# What the libraries have in common, and what they see of one another's insides.

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
    # What other libraries leave in ours (oneTBB's templates, the standard library's) is no business of those who link it.
    target_link_options(${target} PRIVATE LINKER:--exclude-libs,ALL)
  endif()
endfunction()

# clsdf_internals(<target> [<folder>...]): <target>_internals, for tests of what is inside a library and for the libraries beside it. Whoever
# links it sees the library's own headers, those in the folders included. A static library has all the code; a shared one hides it, so here it is once more,
# in a static library that is not installed. Link the library itself first, so that what it shows is taken from it.
function(clsdf_internals target)
  set(internals ${target}_internals)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    add_library(${internals} INTERFACE)
    target_link_libraries(${internals} INTERFACE ${target})
    set(scope INTERFACE)
  else()
    get_target_property(sources ${target} SOURCES)
    add_library(${internals} STATIC ${sources})
    add_dependencies(${internals} ${target})
    foreach(property COMPILE_OPTIONS COMPILE_DEFINITIONS LINK_LIBRARIES INCLUDE_DIRECTORIES)
      get_target_property(value ${target} ${property})
      if(value)
        set_target_properties(${internals} PROPERTIES ${property} "${value}")
      endif()
    endforeach()
    set_target_properties(${internals} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    target_compile_definitions(${internals} PRIVATE CLSDF_STATIC_BUILD)
    set(scope PUBLIC)
  endif()
  target_include_directories(${internals} ${scope} ${PROJECT_SOURCE_DIR}/lib ${PROJECT_SOURCE_DIR}/kernels ${ARGN}
                                                   $<TARGET_PROPERTY:clsdf,CLSDF_KERNEL_SOURCES>)
endfunction()
