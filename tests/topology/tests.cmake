clsdf_test(topology_one_rings one_rings.cpp LABELS topology mesh LINK TBB::tbb)
clsdf_test(topology_morton_order morton_order.cpp LABELS topology LINK TBB::tbb)
clsdf_test(mesh_topology LABELS topology frusta LINK clsdf::reference clsdf::io OpenCL::OpenCL)
