clsdf_test(segment_crossings LABELS segments)
clsdf_field_test(links LABELS segments)
clsdf_field_test(rays LABELS segments)
clsdf_test(stencils LABELS segments)
