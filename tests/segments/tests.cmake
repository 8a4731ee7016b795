clsdf_test(segment_crossings LABELS segments)
clsdf_field_test(exact_signs LABELS segments sign)
clsdf_field_test(links LABELS segments)
clsdf_field_test(rays LABELS segments)
