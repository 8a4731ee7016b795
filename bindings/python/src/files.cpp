#include "files.hpp"

#include <clsdf/io.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf::python {

nb::dlpack::dtype dtype_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return nb::dtype<double>();
        case ElementType::uint32:
            return nb::dtype<std::uint32_t>();
        case ElementType::uint8:
            return nb::dtype<std::uint8_t>();
        default:
            return nb::dtype<float>();
    }
}

FieldSlab slab_of(const ArraysByName& arrays, const char* what, HeldArrays& held) {
    FieldSlab slab;
    for (const auto& [name, array] : arrays) {
        const OutputInfo& info = output_named(nb::cast<std::string>(name));
        const auto& values =
            held.emplace_back(nb::cast<nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>(array, false));
        if (values.dtype() != dtype_of(info.type)) refuse(std::string(what) + ": '" + info.name + "' has another type");
        slab.set(info.output, std::span(static_cast<const std::byte*>(values.data()), values.nbytes()));
    }
    return slab;
}

FieldDescription described(const Grid& grid, const Band& band, const std::string& sign, const std::string& mesh_name,
                           bool positive_inside, std::optional<double> floor) {
    FieldDescription field;
    field.grid = grid;
    field.band = band;
    field.sign = value_named("sign", sign,
                             {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::solid_angle,
                              SignRule::below, SignRule::none});
    field.mesh_name = mesh_name;
    field.positive_inside = positive_inside;
    field.floor = floor;
    return field;
}

namespace {

// The file's field: (grid, band, sign, mesh_name, {output: array}, positive_inside, floor). The arrays share the memory
// that was read.
nb::tuple read(const std::string& path) {
    std::unique_ptr<Field> field;
    {
        const nb::gil_scoped_release no_gil;
        field = std::make_unique<Field>(read_field(path));
    }
    Field& own = *field;
    const nb::capsule owner = owner_of(std::move(field));
    nb::dict arrays;
    for (const OutputInfo& info : output_table()) {
        const auto bytes = own.bytes(info.output);
        if (bytes.empty()) continue;
        std::vector<std::size_t> shape;
        for (const std::int64_t side : shape_of(own.grid.size)) shape.push_back(static_cast<std::size_t>(side));
        if (info.components > 1) shape.push_back(info.components);
        arrays[info.name] = nb::cast(nb::ndarray<nb::numpy>(bytes.data(), shape.size(), shape.data(), owner, nullptr,
                                                            dtype_of(info.type), nb::device::cpu::value));
    }
    return nb::make_tuple(own.grid, own.band, name_of(own.sign), own.mesh_name, arrays, own.positive_inside, own.floor);
}

using GroupNumbers = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

FieldWriter writer(const std::string& path, const Grid& grid, const Band& band, const std::string& sign,
                   const std::string& mesh_name, const std::vector<std::string>& outputs, bool positive_inside,
                   const std::vector<std::string>& group_names, const std::optional<GroupNumbers>& group_numbers,
                   std::optional<double> floor) {
    OutputSet wanted;
    for (const std::string& name : outputs) wanted.insert(output_named(name).output);
    FieldDescription field = described(grid, band, sign, mesh_name, positive_inside, floor);
    if (group_numbers && !group_names.empty()) {
        const std::span numbers(group_numbers->data(), group_numbers->size());
        field.groups = std::make_shared<const FaceGroups>(FaceGroups{group_names, {numbers.begin(), numbers.end()}});
    }
    const nb::gil_scoped_release no_gil;
    return FieldWriter(path, field, wanted);
}

void append(FieldWriter& writer, const ArraysByName& arrays) {
    HeldArrays held;
    const FieldSlab slab = slab_of(arrays, "append", held);
    const nb::gil_scoped_release no_gil;
    writer.append(slab);
}

void finish(FieldWriter& writer) {
    const nb::gil_scoped_release no_gil;
    writer.finish();
}

void write_amr(const std::string& path, const std::vector<std::pair<Grid, ArraysByName>>& boxes) {
    HeldArrays held;
    std::vector<CellBox> views;
    for (const auto& [grid, arrays] : boxes) views.push_back({grid, slab_of(arrays, "write_overlapping_amr", held)});
    const nb::gil_scoped_release no_gil;
    write_overlapping_amr(views, path);
}

}  // namespace

void add_files(nb::module_& module) {
    module.def("read_field", &read, nb::arg("path"),
               nb::sig("def read_field(path: str) -> tuple[Grid, Band, str, str, dict[str, typing.Any], bool, "
                       "float | None]"));
    nb::class_<FieldWriter>(module, "Writer", "A FieldWriter of the library; clsdf.FieldWriter is its Python face.")
        .def("append", &append, nb::arg("arrays"))
        .def("finish", &finish);
    module.def("writer", &writer, nb::arg("path"), nb::arg("grid"), nb::arg("band"), nb::arg("sign"),
               nb::arg("mesh_name"), nb::arg("outputs"), nb::arg("positive_inside") = false,
               nb::arg("group_names") = std::vector<std::string>(), nb::arg("group_numbers") = nb::none(),
               nb::arg("floor") = nb::none());
    module.def("write_overlapping_amr", &write_amr, nb::arg("path"), nb::arg("boxes"));
    module.def(
        "check_field_path", [](const std::string& path) { check_field_path(path); }, nb::arg("path"),
        "Raises the error that writing to the path would raise for its ending or its folder.");
}

}  // namespace clsdf::python
