clsdf_test(mesh_defects defects.cpp LABELS tools)

# The shapes' saddle vertices are counted with an exact predicate.
clsdf_test(shapes LABELS tools LINK CGAL::CGAL)
