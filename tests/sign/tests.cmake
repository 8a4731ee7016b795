clsdf_field_test(topology LABELS sign mesh)
clsdf_field_test(unbalanced_meshes LABELS sign mesh points)
clsdf_field_test(open_meshes LABELS sign mesh points)
