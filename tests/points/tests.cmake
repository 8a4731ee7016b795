clsdf_field_test(query LABELS points tree)
clsdf_field_test(nearest_by_group LABELS points tree)
clsdf_field_test(classify LABELS points)
