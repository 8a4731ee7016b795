clsdf_test(binary_tree LABELS tree LINK clsdf::reference OpenCL::OpenCL AS_GPU)
clsdf_test(point_faces LABELS tree points LINK clsdf::reference OpenCL::OpenCL AS_GPU)
