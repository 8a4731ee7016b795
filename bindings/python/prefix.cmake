# The folder clsdf of the package is also the prefix of an installation: clsdf/bin, clsdf/lib, clsdf/include, clsdf/share. The
# extension links its libraries. It has no GPL code, no cairo, and no documents.
set(CMAKE_INSTALL_BINDIR clsdf/bin)
set(CMAKE_INSTALL_LIBDIR clsdf/lib)
set(CMAKE_INSTALL_INCLUDEDIR clsdf/include)
set(CMAKE_INSTALL_DATAROOTDIR clsdf/share)
set(CMAKE_INSTALL_RPATH $ORIGIN $ORIGIN/../lib)
# No loader searches a folder of Python's packages.
set(CLSDF_PC_RPATH "-Wl,-rpath,\${libdir} ")
add_subdirectory(../.. clsdf)

# A wheel has no symbolic links. Each library is one file, under the name that programs load; for linkers a text under the
# short name leads to it.
foreach(library clsdf clsdf_meshes clsdf_cuda clsdf_io clsdf_papers clsdf_c clsdf_c_io)
  get_target_property(version ${library} SOVERSION)
  set_target_properties(${library} PROPERTIES VERSION ${version})
  install(CODE "set(name \"\${CMAKE_INSTALL_PREFIX}/clsdf/lib/$<TARGET_LINKER_FILE_NAME:${library}>\")
file(REMOVE \"\${name}\")
file(WRITE \"\${name}\" \"INPUT($<TARGET_SONAME_FILE_NAME:${library}>)\\n\")")
endforeach()
