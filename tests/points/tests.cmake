clsdf_field_test(query batches.cpp few_points.cpp unusable_points.cpp LABELS points tree)
clsdf_field_test(nearest_by_group LABELS points tree)
clsdf_field_test(classify LABELS points)
