clsdf_test(mesh LABELS mesh)
clsdf_test(expansions LABELS mesh surface launch points LINK clsdf::reference OpenCL::OpenCL)
