# clsdf_papers_test(<name> <source>...): what the papers published, held against the reference. It sees their library's headers.
function(clsdf_papers_test name)
  clsdf_test(${name} ${ARGN})
  target_link_libraries(test_${name} PRIVATE clsdf::papers clsdf_papers_internals clsdf::reference OpenCL::OpenCL)
endfunction()

foreach(name classification root_sums saddles)
  clsdf_papers_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
  target_link_libraries(test_${name} PRIVATE CGAL::CGAL)
endforeach()
clsdf_papers_test(polyhedra_convex_polyhedron ${CMAKE_CURRENT_LIST_DIR}/convex_polyhedron.cpp)
clsdf_papers_test(peikert_sigg_polyhedra ${CMAKE_CURRENT_LIST_DIR}/polyhedra.cpp)
clsdf_papers_test(bounding_solids ${CMAKE_CURRENT_LIST_DIR}/solids.cpp)
foreach(name paper scan pieces)
  clsdf_papers_test(slices_${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
endforeach()
foreach(name leaned mauch)
  clsdf_papers_test(slices_${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp ${CMAKE_CURRENT_LIST_DIR}/exact.cpp)
  target_compile_definitions(test_slices_${name} PRIVATE CLSDF_SCANNED=${name})
endforeach()

clsdf_papers_test(brute_force ${CMAKE_CURRENT_LIST_DIR}/brute_force.cpp)
clsdf_papers_test(software_scan ${CMAKE_CURRENT_LIST_DIR}/software_scan.cpp)

# The messages of a command that is built without clsdf::papers.
clsdf_test(papers_absent ${CMAKE_CURRENT_LIST_DIR}/absent.cpp)
target_link_libraries(test_papers_absent PRIVATE clsdf_papers_absent)
