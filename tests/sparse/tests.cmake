clsdf_field_test(fields LABELS sparse bricks)
clsdf_field_test(plans LABELS sparse plans targets)
clsdf_field_test(nvdb_files LABELS sparse io)
target_link_libraries(test_sparse_fields PRIVATE clsdf::papers)
