#include "body.hpp"
#include "files.hpp"

#include <clsdf/io.hpp>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::python {

namespace {

using Bricks = nb::ndarray<const std::int64_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Runs = nb::ndarray<const std::int64_t, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Samples = Bricks;
using Distances = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;

static_assert(sizeof(Index3) == 3 * sizeof(std::int64_t) && sizeof(BrickRun) == 4 * sizeof(std::int64_t) &&
              std::is_standard_layout_v<BrickRun>);

OutputSet outputs_of(const std::vector<std::string>& names) {
    OutputSet outputs;
    for (const std::string& name : names) outputs.insert(output_named(name).output);
    return outputs;
}

template <typename Value, typename Items>
nb::object array_of(const Items& items, std::size_t columns, const nb::capsule& owner) {
    return nb::cast(nb::ndarray<nb::numpy, Value, nb::ndim<2>>(
        const_cast<void*>(static_cast<const void*>(items.data())), {items.size(), columns}, owner));
}

// (bricks, inside, {output: array}), in the memory of the field; without arrays that have no items.
nb::tuple arrays_of(SparseField computed) {
    auto own = std::make_unique<SparseField>(std::move(computed));
    SparseField& field = *own;
    const nb::capsule owner = owner_of(std::move(own));
    nb::object bricks = nb::none(), inside = nb::none();
    if (!field.bricks.empty()) bricks = array_of<std::int64_t>(field.bricks, 3, owner);
    if (!field.inside.empty()) inside = array_of<std::int64_t>(field.inside, 4, owner);
    nb::dict arrays;
    for (const OutputInfo& info : output_table()) {
        const std::span<std::byte> bytes = field.bytes(info.output);
        if (bytes.empty()) continue;
        std::vector<std::size_t> shape{field.bricks.size(), 8, 8, 8};
        if (info.components > 1) shape.push_back(info.components);
        arrays[info.name] = nb::cast(nb::ndarray<nb::numpy>(bytes.data(), shape.size(), shape.data(), owner, nullptr,
                                                            dtype_of(info.type), nb::device::cpu::value));
    }
    return nb::make_tuple(bricks, inside, arrays);
}

nb::tuple compute(const Body& body, const Grid& grid, const Band& band, const std::vector<std::string>& outputs,
                  nb::object progress, nb::handle wait_for) {
    const OutputSet wanted = outputs_of(outputs);
    const Call call(std::move(progress), wait_for);
    return arrays_of(body.read([&](const DistanceTransform& transform) {
        return transform.compute_sparse(grid, band, wanted, call.options());
    }));
}

nb::list compute_many(const Body& body, const std::vector<std::pair<Grid, Band>>& grids,
                      const std::vector<std::string>& outputs, nb::object progress) {
    const OutputSet wanted = outputs_of(outputs);
    std::vector<SparseRequest> requests;
    for (const auto& [grid, band] : grids) requests.push_back({grid, band, wanted});
    const Call call(std::move(progress));
    nb::list all;
    for (SparseField& field : body.read(
             [&](const DistanceTransform& transform) { return transform.compute_sparse(requests, call.options()); }))
        all.append(arrays_of(std::move(field)));
    return all;
}

void compute_file(const Body& body, const std::string& path, const Grid& grid, const Band& band,
                  const std::vector<std::string>& outputs, const std::string& sign, const std::string& mesh_name,
                  nb::object progress, std::optional<double> floor) {
    const OutputSet wanted = outputs_of(outputs);
    const FieldDescription field = described(grid, band, sign, mesh_name, false, floor);
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        SparseFieldWriter writer(path, field, wanted);
        transform.compute_sparse(
            grid, band, wanted, [&](const SparseSlab& layers) { writer.append(layers); }, call.options());
        writer.finish();
    });
}

std::span<const Index3> triples_of(const Bricks& array) {
    return {reinterpret_cast<const Index3*>(array.data()), array.shape(0)};
}

std::span<const BrickRun> runs_of(const Runs& array) {
    return {reinterpret_cast<const BrickRun*>(array.data()), array.shape(0)};
}

void write(const std::string& path, const Grid& grid, const Band& band, const std::string& sign,
           const std::string& mesh_name, bool positive_inside, const Bricks& bricks, const Runs& inside,
           const ArraysByName& arrays, std::optional<double> floor) {
    const FieldDescription field = described(grid, band, sign, mesh_name, positive_inside, floor);
    HeldArrays held;
    SparseSlab layers{in_whole_bricks(grid), triples_of(bricks), slab_of(arrays, "write", held), runs_of(inside)};
    OutputSet outputs;
    for (const auto& [name, array] : arrays) outputs.insert(output_named(nb::cast<std::string>(name)).output);
    const nb::gil_scoped_release no_gil;
    SparseFieldWriter writer(path, field, outputs);
    writer.append(layers);
    writer.finish();
}

// (grid, band, sign, mesh_name, arrays_of(), positive_inside, floor), or None for a file of a dense field.
nb::object read(const std::string& path) {
    std::optional<SparseField> field;
    {
        const nb::gil_scoped_release no_gil;
        OutputSet all(Output::distance);
        for (const OutputInfo& info : output_table()) all.insert(info.output);
        field = read_sparse_field(path, all);
    }
    if (!field) return nb::none();
    const FieldDescription about = *field;
    return nb::make_tuple(about.grid, about.band, name_of(about.sign), about.mesh_name, arrays_of(std::move(*field)),
                          about.positive_inside, about.floor);
}

auto vector_of(std::unique_ptr<std::vector<std::int64_t>> own) {
    const std::size_t count = own->size();
    return array_in<nb::ndarray<nb::numpy, std::int64_t, nb::ndim<1>>>(std::move(*own), {count});
}

auto find(const Bricks& bricks, const Samples& samples) {
    auto numbers = std::make_unique<std::vector<std::int64_t>>();
    {
        const SparseSlab layers{{}, triples_of(bricks), {}, {}};
        const std::span<const Index3> all = triples_of(samples);
        const nb::gil_scoped_release no_gil;
        numbers->reserve(all.size());
        for (const Index3& sample : all) {
            const auto number = layers.find(sample);
            numbers->push_back(number ? static_cast<std::int64_t>(*number) : -1);
        }
    }
    return vector_of(std::move(numbers));
}

void distances(const Bricks& bricks, const Runs& inside, const Distances& distance, const Band& band,
               const Samples& samples, nb::ndarray<float, nb::ndim<1>, nb::c_contig, nb::device::cpu> results) {
    if (distance.size() != bricks.shape(0) * brick_samples || results.shape(0) != samples.shape(0))
        refuse("the distances are not those of the bricks, 512 each");
    FieldSlab values;
    values.set(Output::distance, std::span(distance.data(), distance.size()));
    const SparseSlab layers{{}, triples_of(bricks), values, runs_of(inside)};
    const std::span<const Index3> all = triples_of(samples);
    float* to = results.data();
    const nb::gil_scoped_release no_gil;
    for (const Index3& sample : all) *to++ = layers.distance_at(sample, band);
}

}  // namespace

void add_sparse_fields(nb::module_& module) {
    module.def("compute_sparse", &compute, nb::arg("body"), nb::arg("grid"), nb::arg("band"), nb::arg("outputs"),
               nb::arg("progress").none(), nb::arg("wait_for").none(),
               nb::sig("def compute_sparse(body: Body, grid: Grid, band: Band, outputs: typing.Sequence[str], "
                       "progress: object | None, wait_for: object | None) "
                       "-> tuple[typing.Any, typing.Any, dict[str, typing.Any]]"),
               "(bricks, inside, {output: array}); None for bricks or runs if there are none.");
    module.def("compute_sparse_many", &compute_many, nb::arg("body"), nb::arg("grids"), nb::arg("outputs"),
               nb::arg("progress").none(),
               nb::sig("def compute_sparse_many(body: Body, grids: typing.Sequence[tuple[Grid, Band]], "
                       "outputs: typing.Sequence[str], progress: object | None) "
                       "-> list[tuple[typing.Any, typing.Any, dict[str, typing.Any]]]"),
               "A grid and its band each.");
    module.def("compute_sparse_file", &compute_file, nb::arg("body"), nb::arg("path"), nb::arg("grid"), nb::arg("band"),
               nb::arg("outputs"), nb::arg("sign"), nb::arg("mesh_name"), nb::arg("progress").none(),
               nb::arg("floor").none() = nb::none(),
               "Computes a sparse field into a file, a few layers in memory at a time.");
    module.def("write_sparse", &write, nb::arg("path"), nb::arg("grid"), nb::arg("band"), nb::arg("sign"),
               nb::arg("mesh_name"), nb::arg("positive_inside"), nb::arg("bricks"), nb::arg("inside"),
               nb::arg("arrays"), nb::arg("floor").none() = nb::none());
    module.def("read_sparse_field", &read, nb::arg("path"),
               nb::sig("def read_sparse_field(path: str) -> tuple[Grid, Band, str, str, "
                       "tuple[typing.Any, typing.Any, dict[str, typing.Any]], bool, float | None] | None"));
    module.def("find_bricks", &find, nb::arg("bricks"), nb::arg("samples"),
               "The number of the brick of each sample, -1 without one.");
    module.def("sparse_distances", &distances, nb::arg("bricks"), nb::arg("inside"), nb::arg("distance"),
               nb::arg("band"), nb::arg("samples"), nb::arg("results"));
}

}  // namespace clsdf::python
