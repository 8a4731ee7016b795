clsdf_test(binary_tree LABELS tree LINK clsdf::reference OpenCL::OpenCL AS_GPU)
