clsdf_field_test(topology LABELS sign surface)
clsdf_field_test(unbalanced_meshes LABELS sign surface points)
clsdf_field_test(open_meshes LABELS sign surface points)
clsdf_field_test(terrains LABELS sign surface points)
