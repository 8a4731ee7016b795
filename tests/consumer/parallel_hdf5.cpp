// A simulation with parallel HDF5: every process reads a mesh, computes its slices of a field and writes them into one
// file. The first one computes the whole field, and compares the file value by value.
#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <hdf5.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iostream>
#include <string>
#include <vector>

namespace {

constexpr const char* path = "parallel.h5";

hid_t opened_by(MPI_Comm processes, bool is_new) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (H5Pset_fapl_mpio(access, processes, MPI_INFO_NULL) < 0)
        throw clsdf::Error(clsdf::ErrorCode::output_failure, "mpio");
    const hid_t file =
        is_new ? H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access) : H5Fopen(path, H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

int run() {
    int rank = 0, ranks = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    if (ranks < 2) throw clsdf::Error(clsdf::ErrorCode::invalid_argument, "start two processes or more");

    const std::string mesh_path = "knot" + std::to_string(rank) + ".ply";
    clsdf::write_mesh(clsdf::make_shape("knot"), mesh_path);
    const clsdf::Mesh mesh = clsdf::read_mesh(mesh_path);
    const clsdf::Band band = clsdf::Band::full();
    const clsdf::Grid grid = clsdf::Grid::around(mesh, 64, band);
    clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
    const clsdf::Field whole = transform.compute(grid, band);

    const std::int64_t begin = grid.size[2] * rank / ranks, end = grid.size[2] * (rank + 1) / ranks;
    const clsdf::Field part =
        transform.compute(grid.part({0, 0, begin}, {grid.size[0], grid.size[1], end - begin}), band);
    const std::array<hsize_t, 3> shape{static_cast<hsize_t>(grid.size[2]), static_cast<hsize_t>(grid.size[1]),
                                       static_cast<hsize_t>(grid.size[0])};
    const std::array<hsize_t, 3> first{static_cast<hsize_t>(begin), 0, 0};
    const std::array<hsize_t, 3> count{static_cast<hsize_t>(end - begin), shape[1], shape[2]};

    const hid_t file = opened_by(MPI_COMM_WORLD, true);
    const hid_t room = H5Screate_simple(3, shape.data(), nullptr), slices = H5Screate_simple(3, count.data(), nullptr);
    H5Sselect_hyperslab(room, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr);
    const hid_t array = H5Dcreate2(file, "distance", H5T_IEEE_F32LE, room, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    bool good = H5Dwrite(array, H5T_NATIVE_FLOAT, slices, room, H5P_DEFAULT, part.distance().data()) >= 0;
    H5Dclose(array);
    H5Sclose(slices);
    H5Sclose(room);
    H5Fclose(file);
    MPI_Barrier(MPI_COMM_WORLD);

    if (rank == 0) {
        const hid_t written = opened_by(MPI_COMM_SELF, false);
        const hid_t values = H5Dopen2(written, "distance", H5P_DEFAULT);
        std::vector<float> read(whole.distance().size());
        good = good && H5Dread(values, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, read.data()) >= 0;
        H5Dclose(values);
        H5Fclose(written);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < read.size(); ++i)
            wrong += std::memcmp(&read[i], &whole.distance()[i], sizeof(float)) != 0 ? 1 : 0;
        std::cout << wrong << " of " << read.size() << " values that " << ranks << " processes wrote are wrong\n";
        good = good && wrong == 0;
    }
    return good ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
    MPI_Init(&count, &arguments);
    int status = 1;
    try {
        status = run();
    } catch (const clsdf::Error& error) {
        std::cerr << error.what() << '\n';
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    MPI_Finalize();
    return status;
}
