#include "support/exact_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

// Files of sparse fields are read again with the same bricks, and as dense fields with the same samples.

using namespace clsdf;
using namespace clsdf::test;

namespace {

const OutputSet extras = Output::triangle | Output::gradient;

SparseField sphere_field(OutputSet outputs = extras) {
    static const Mesh mesh = make_shape("sphere4");
    const Grid grid = grid_around(mesh, 60, 5).part({3, 2, 9}, {47, 55, 40});
    return DistanceTransform(test_device(), mesh)
        .compute_sparse(grid, Band{3 * grid.voxel(), 2 * grid.voxel()}, outputs);
}

bool has_same_bytes(std::span<const std::byte> one, std::span<const std::byte> other) {
    return std::ranges::equal(one, other);
}

void check_equal(const SparseField& found, const SparseField& expected) {
    BOOST_CHECK(found.grid == expected.grid);
    BOOST_CHECK(found.bricks == expected.bricks);
    BOOST_CHECK(found.inside == expected.inside);
    BOOST_CHECK(found.outputs() == expected.outputs());
    BOOST_CHECK(found.positive_inside == expected.positive_inside);
    for (const OutputInfo& info : output_table())
        BOOST_TEST(has_same_bytes(found.bytes(info.output), expected.bytes(info.output)), info.name);
}

void check_equal(const Field& found, const Field& expected) {
    BOOST_CHECK(found.grid == expected.grid);
    BOOST_CHECK(found.outputs() == expected.outputs());
    for (const OutputInfo& info : output_table())
        BOOST_TEST(has_same_bytes(found.bytes(info.output), expected.bytes(info.output)), info.name);
}

/// Replaces bytes of a file.
void patch(const std::string& path, std::uint64_t offset, const void* bytes, std::size_t count) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(offset));
    file.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
    BOOST_REQUIRE(file.good());
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_sparse_field)

BOOST_AUTO_TEST_CASE(becomes_the_dense_field) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid whole = grid_around(mesh, 60, 5);
    for (const Grid& grid : {whole, whole.part({3, 2, 9}, {47, 55, 40}), whole.block({-9, 5, -20}, {70, 30, 50})}) {
        const Band band{3 * grid.voxel(), 2 * grid.voxel()};
        check_equal(to_dense(transform.compute_sparse(grid, band, extras)), transform.compute(grid, band, extras));
    }
}

BOOST_AUTO_TEST_CASE(is_read_from_its_arrays_as_it_was_written) {
    const SparseField field = sphere_field();
    for (const std::string ending : {".npy", ".h5"}) {
        const TemporaryFolder folder;
        const std::string path = folder.file("field" + ending);
        write_field(field, path);
        const std::optional<SparseField> found = read_sparse_field(path, extras);
        BOOST_REQUIRE(found.has_value());
        check_equal(*found, field);
        check_equal(read_field(path), to_dense(field));
        BOOST_TEST(missing_field_files(path).empty());
        BOOST_TEST(read_sparse_field(path)->outputs().bits() == OutputSet(Output::distance).bits());
    }
}

BOOST_AUTO_TEST_CASE(has_the_same_bytes_layer_by_layer) {
    const SparseField field = sphere_field();
    for (const std::string ending : {".npy", ".h5"}) {
        const TemporaryFolder at_once, layers;
        write_field(field, at_once.file("field" + ending));
        SparseFieldWriter writer(layers.file("field" + ending), field, extras);
        const SparseSlab all = field.slab();
        std::size_t brick = 0, run = 0;
        for (std::int64_t z = 0; z < all.part.size[2]; z += brick_side) {
            SparseSlab slab{all.part};
            slab.part.first[2] += z;
            slab.part.size[2] = brick_side;
            const std::int64_t at = slab.part.first[2];
            const std::size_t first = brick, first_run = run;
            while (brick < field.bricks.size() && field.bricks[brick][2] == at) ++brick;
            while (run < field.inside.size() && field.inside[run].first[2] == at) ++run;
            slab.bricks = all.bricks.subspan(first, brick - first);
            slab.inside = all.inside.subspan(first_run, run - first_run);
            for (const OutputInfo& info : output_table()) {
                const std::size_t bytes = brick_samples * info.sample_bytes();
                if (!field.bytes(info.output).empty())
                    slab.values.set(info.output,
                                    field.bytes(info.output).subspan(first * bytes, (brick - first) * bytes));
            }
            writer.append(slab);
        }
        writer.finish();
        BOOST_TEST(layers.file_count() == at_once.file_count());
        for (const auto& entry : std::filesystem::directory_iterator(at_once.file(""))) {
            const std::string name = entry.path().filename().string();
            BOOST_TEST((content_of(entry.path().string()) == content_of(layers.file(name))), name);
        }
    }
}

BOOST_AUTO_TEST_CASE(may_be_positive_inside_or_have_no_brick) {
    SparseField negated = sphere_field(Output::distance);
    for (float& value : negated.distance()) value = -value;
    negated.positive_inside = true;
    SparseField empty;
    static_cast<FieldDescription&>(empty) = sphere_field(Output::distance);
    empty.inside = {{in_whole_bricks(empty.grid).first, 2}};
    for (const SparseField& field : {negated, empty})
        for (const std::string ending : {".npy", ".h5"}) {
            const TemporaryFolder folder;
            write_field(field, folder.file("field" + ending));
            check_equal(read_sparse_field(folder.file("field" + ending)).value(), field);
            const Field dense = read_field(folder.file("field" + ending));
            const Index3& first = field.grid.first;
            for (std::size_t n = 0; n < dense.distance().size(); n += 7) {
                const auto at = static_cast<std::int64_t>(n);
                const Index3& size = field.grid.size;
                const Index3 sample{first[0] + at % size[0], first[1] + at / size[0] % size[1],
                                    first[2] + at / size[0] / size[1]};
                BOOST_REQUIRE_EQUAL(dense.distance()[n], field.distance_at(sample));
            }
        }
}

BOOST_AUTO_TEST_CASE(is_read_from_a_tree_with_the_samples_of_the_dense_field) {
    const std::vector<std::string> endings{".nvdb", CLSDF_WITH_OPENVDB ? ".vdb" : ".nvdb"};
    for (const std::string& ending : endings) {
        const OutputSet outputs = ending == ".vdb" ? extras : Output::distance;
        const SparseField field = sphere_field(outputs);
        const TemporaryFolder folder;
        write_field(field, folder.file("field" + ending));
        const std::optional<SparseField> found = read_sparse_field(folder.file("field" + ending), extras);
        BOOST_REQUIRE(found.has_value());
        check_equal(to_dense(*found), to_dense(field));
        for (const Index3& brick : found->bricks) BOOST_CHECK(field.find(brick).has_value());
    }
}

BOOST_AUTO_TEST_CASE(leaves_no_xdmf_of_a_dense_field_beside_it) {
    const SparseField field = sphere_field(Output::distance);
    const TemporaryFolder folder;
    write_field(to_dense(field), folder.file("field.h5"));
    BOOST_TEST(std::filesystem::exists(folder.file("field.xdmf")));
    write_field(field, folder.file("field.h5"));
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(is_told_from_a_dense_one) {
    const TemporaryFolder folder;
    Field dense = to_dense(sphere_field(Output::distance));
    for (const std::string ending : {".npy", ".h5", ".nrrd"}) {
        write_field(dense, folder.file("dense" + ending));
        BOOST_TEST(!read_sparse_field(folder.file("dense" + ending)).has_value());
    }
    for (const std::string ending : {".npy", ".h5"})
        check_throws(ErrorCode::unreadable_input, {"missing" + ending},
                     [&] { read_sparse_field(folder.file("missing" + ending)); });
    for (const std::string ending : {".npy", ".h5", ".vdb", ".nvdb"})
        BOOST_TEST(stores_sparse_fields(folder.file("a" + ending)));
    BOOST_TEST(!stores_sparse_fields(folder.file("a.nrrd")));
    BOOST_TEST(stores_sparse_fields_only(folder.file("a.vdb")));
    BOOST_TEST(!stores_sparse_fields_only(folder.file("a.npy")));
}

BOOST_AUTO_TEST_CASE(that_makes_no_sense_is_refused) {
    const SparseField field = sphere_field(Output::distance);
    BOOST_REQUIRE(field.bricks.size() > 2U);
    const TemporaryFolder folder;
    const std::string path = folder.file("field.npy"), bricks = folder.file("field_bricks.npy"),
                      runs = folder.file("field_inside_runs.npy");
    const auto refused = [&](const std::vector<std::string>& parts) {
        check_throws(ErrorCode::unreadable_input, parts, [&] { read_field(path); });
        check_throws(ErrorCode::unreadable_input, parts, [&] { read_sparse_field(path); });
    };
    constexpr std::uint64_t header = 128;
    const auto write = [&] { write_field(field, path); };
    write();
    patch(bricks, header, &field.bricks[1], sizeof(Index3));
    refused({"field.npy", "order"});
    write();
    const Index3 oblique{field.bricks[0][0] + 1, field.bricks[0][1], field.bricks[0][2]};
    patch(bricks, header, &oblique, sizeof oblique);
    refused({"field.npy", "not in the bricks"});
    write();
    const BrickRun endless{field.inside[0].first, std::numeric_limits<std::int64_t>::max()};
    patch(runs, header, &endless, sizeof endless);
    refused({"field.npy", "not in the bricks"});
    write();
    std::filesystem::resize_file(bricks, std::filesystem::file_size(bricks) - 24);
    refused({"field_bricks.npy", "truncated"});
    write();
    std::filesystem::remove(runs);
    refused({"field_inside_runs.npy", "no such file"});
    BOOST_TEST(missing_field_files(path).size() == 1U);
    write();
    std::filesystem::remove(path + ".json");
    refused({"field.npy", "sparse field", "field.npy.json", "field_bricks.npy", "field_inside_runs.npy"});
    write();
    write_field(to_dense(field), folder.file("other.npy"));
    std::filesystem::rename(folder.file("other.npy"), path);
    refused({"field.npy", "shape"});
}

BOOST_AUTO_TEST_SUITE_END()
