foreach(name nearest_on_triangle oracle exact_sign check reference_field self_intersections)
  clsdf_test(reference_${name} test_${name}.cpp LABELS reference LINK clsdf::reference)
endforeach()

# The messages of a command that is built without clsdf::reference.
clsdf_test(reference_absent absent.cpp LABELS reference LINK clsdf_reference_absent)
