# clsdf_papers_test(<name> <source>... [AS_GPU]): what the papers published, held against the reference. It sees their library's headers.
function(clsdf_papers_test name)
  clsdf_test(${name} ${ARGN} LABELS papers LINK clsdf::papers clsdf_papers_internals clsdf::reference OpenCL::OpenCL)
endfunction()

foreach(name classification root_sums saddles)
  clsdf_papers_test(${name} ${name}.cpp)
  target_link_libraries(test_${name} PRIVATE CGAL::CGAL)
endforeach()
clsdf_papers_test(papers_convex_polyhedron convex_polyhedron.cpp)
clsdf_papers_test(peikert_sigg_polyhedra polyhedra.cpp)
clsdf_papers_test(bounding_solids solids.cpp)
foreach(name paper scan pieces)
  clsdf_papers_test(slices_${name} ${name}.cpp AS_GPU)
endforeach()
foreach(name leaned mauch)
  clsdf_papers_test(slices_${name} ${name}.cpp exact.cpp AS_GPU)
  target_compile_definitions(test_slices_${name} PRIVATE CLSDF_SCANNED=${name})
endforeach()

clsdf_papers_test(brute_force brute_force.cpp AS_GPU)
clsdf_papers_test(software_scan software_scan.cpp)

# The messages of a command that is built without clsdf::papers.
clsdf_test(papers_absent absent.cpp LABELS papers LINK clsdf_papers_absent)
