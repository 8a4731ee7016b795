foreach(name counterexamples random_meshes cone_search slopes_and_sites cluster_index)
  clsdf_test(frusta_${name} ${name}.cpp LABELS frusta LINK TBB::tbb)
endforeach()
clsdf_test(frusta_records records.cpp LABELS frusta lattice LINK TBB::tbb)
# Casts to double of constants that the host and the kernels share.
set_property(SOURCE ${CMAKE_CURRENT_LIST_DIR}/cone_search.cpp APPEND PROPERTY COMPILE_OPTIONS "-Wno-old-style-cast")

clsdf_field_test(kernel_frusta LABELS frusta)
