#include "fuzz/readers.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

namespace clsdf::fuzz {

namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t take_mesh_with(const std::string& path, const ReadOptions& options) {
    const Mesh mesh = read_mesh(path, options);
    if (mesh.triangles().empty()) fail("a mesh without a triangle was given");
    for (const Triangle& triangle : mesh.triangles())
        for (const std::uint32_t corner : triangle) {
            if (corner >= mesh.vertices().size()) fail("a triangle names a vertex that is not there");
            for (const double x : mesh.vertices()[corner])
                if (!std::isfinite(x)) fail("a vertex in use is not finite");
        }
    return mesh.triangles().size() * sizeof(Triangle) + mesh.vertices().size() * sizeof(Vec3);
}

std::size_t take_mesh(const std::string& path) {
    take_mesh_with(path, {.skip_bad_facets = true});
    return take_mesh_with(path, {});
}

std::size_t take_field(const std::string& path) {
    const Field field = read_field(path);
    try {
        field.grid.validate();
        field.band.validate();
    } catch (const Error& error) {
        fail(std::string("a field whose grid or band is not valid was given: ") + error.what());
    }
    if (field.distance().size() != field.grid.sample_count()) fail("the distances do not fit the grid");
    std::size_t bytes = 0;
    for (const OutputInfo& info : output_table()) {
        const std::size_t size = field.bytes(info.output).size();
        if (size != 0 && size != field.grid.sample_count() * info.sample_bytes())
            fail(std::string(info.name) + " does not fit the grid");
        bytes += size;
    }
    return bytes;
}

std::size_t take_points(const std::string& path) {
    return read_points(path).size() * sizeof(Vec3);
}

Field example_field(bool any_spacing, bool has_extras) {
    FieldDescription description;
    description.grid = Grid{{0.1, -1e9 / 3, 1e-5}, {0.1, 1.0 / 3, 1e-20}, {4, 3, 2}, {2, 10, 12}};
    if (!any_spacing) description.grid.spacing.fill(1.0 / 3);
    description.band = {0, std::numeric_limits<double>::infinity()};
    description.sign = SignRule::nonzero;
    description.mesh_name = "a \"mesh\" of\n two\\lines & <more>";
    OutputSet outputs = Output::distance;
    if (has_extras) outputs = {Output::distance, Output::triangle, Output::site, Output::closest};
    Field field(description, outputs);
    for (std::uint32_t i = 0; i < field.grid.sample_count(); ++i) {
        field.distance()[i] = 0.1F * static_cast<float>(i) - 1;
        if (!has_extras) continue;
        field.triangle()[i] = i * i;
        field.site()[i] = static_cast<std::uint8_t>(i % 7);
        constexpr std::array closest{0.1, -1e9 / 3, 1e-300};
        for (std::size_t axis = 0; axis < 3; ++axis) field.closest()[3 * i + axis] = closest[axis] * i;
    }
    return field;
}

Reader mesh_reader(const std::string& format, const fs::path& folder) {
    Reader reader{format, "damaged." + format, "damaged." + format, {}, {}, take_mesh};
    const fs::path sound = folder / ("sound." + format);
    for (const char* shape : {"tetrahedron", "sphere1"}) {
        write_mesh(make_shape(shape), sound.string());
        reader.seeds.push_back(content_of(sound));
    }
    fs::remove(sound);
    return reader;
}

/// `damaged`: the part of a file's name after "field" that is damaged, e.g. ".npy.json"; the others lie beside it.
Reader field_reader(const std::string& format, const std::string& ending, const std::string& damaged,
                    const fs::path& folder) {
    Reader reader{format, "field" + damaged, "field" + ending, {}, {}, take_field};
    const bool is_plain = ending == ".sdf" || ending == ".vdb";
    // Several fields, so that a damaged file has more than one way to be sound.
    for (const bool has_extras : {true, false}) {
        if (has_extras && (ending == ".sdf" || ending == ".nvdb")) continue;
        const fs::path sound = folder / "sound";
        fs::create_directory(sound);
        write_field(example_field(!is_plain, has_extras), (sound / ("field" + ending)).string());
        if (fs::exists(sound / reader.damaged)) reader.seeds.push_back(content_of(sound / reader.damaged));
        if (reader.beside.empty())
            for (const auto& entry : fs::directory_iterator(sound))
                if (entry.path().filename() != reader.damaged)
                    reader.beside.emplace_back(entry.path().filename().string(), content_of(entry.path()));
        fs::remove_all(sound);
    }
    // Values that are compressed, or stated once for many samples, may take few bytes.
    if (ending == ".h5" || ending == ".vtkhdf" || ending == ".vdb" || ending == ".nvdb") reader.expansion = 4096;
    return reader;
}

template <typename Number>
std::string npy_of(const char* type, const std::vector<Number>& coordinates) {
    std::string header = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (" +
                         std::to_string(coordinates.size() / 3) + ", 3), }\n";
    return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header +
           std::string(reinterpret_cast<const char*>(coordinates.data()), coordinates.size() * sizeof(Number));
}

/// `ending`: of "points.csv".
Reader point_reader(const std::string& format, const std::string& ending, const fs::path& folder) {
    Reader reader{format, "points." + ending, "points." + ending, {}, {}, take_points};
    if (ending == "npy") {  // which write_points() writes of results alone
        reader.seeds = {npy_of("<f8", std::vector<double>{0.1, -1e9 / 3, 1e-300, 1, 2, 3}),
                        npy_of("<f4", std::vector<float>{0.1F, -1e9F, 1e-30F, 1, 2, 3, 4, 5, 6})};
        return reader;
    }
    const fs::path sound = folder / ("sound." + ending);
    FieldSlab results;
    const std::vector<float> distance{0.1F, -2};
    const std::vector<std::uint32_t> triangle{7, 8};
    results.set(Output::distance, std::span(distance));
    for (const bool has_triangles : {false, true}) {
        if (has_triangles) results.set(Output::triangle, std::span(triangle));
        write_points(std::vector<Vec3>{{0.1, -1e9 / 3, 1e-300}, {1, 2, 3}}, results, sound.string());
        reader.seeds.push_back(content_of(sound));
    }
    fs::remove(sound);
    return reader;
}

struct FieldFormat {
    const char* format;
    const char* ending;
    const char* damaged;
};
constexpr std::array field_formats {
    FieldFormat{"nrrd", ".nrrd", ".nrrd"}, FieldFormat{"nrrd_triangle", ".nrrd", "_triangle.nrrd"},
        FieldFormat{"npy", ".npy", ".npy"}, FieldFormat{"npy_json", ".npy", ".npy.json"},
        FieldFormat{"vti", ".vti", ".vti"}, FieldFormat{"vtkhdf", ".vtkhdf", ".vtkhdf"},
        FieldFormat{"h5", ".h5", ".h5"}, FieldFormat{"nvdb", ".nvdb", ".nvdb"}, FieldFormat{"sdf", ".sdf", ".sdf"},
#if CLSDF_WITH_OPENVDB
        FieldFormat{"vdb", ".vdb", ".vdb"},
#endif
};
constexpr std::array mesh_formats{"off", "obj", "stl", "ply"};
constexpr std::array point_formats{"points_csv", "points_npy", "points_ply"};

std::string spelt(const std::string& text) {
    std::string bytes;
    std::string digits;
    for (const char c : text) {
        if (std::isxdigit(static_cast<unsigned char>(c)) != 0) digits += c;
        if (digits.size() < 2) continue;
        bytes += static_cast<char>(std::stoi(digits, nullptr, 16));
        digits.clear();
    }
    return bytes;
}

}  // namespace

std::vector<std::string> formats() {
    std::vector<std::string> names(mesh_formats.begin(), mesh_formats.end());
    names.insert(names.end(), point_formats.begin(), point_formats.end());
    for (const FieldFormat& field : field_formats) names.emplace_back(field.format);
    return names;
}

Reader reader_of(const std::string& format, const fs::path& folder) {
    if (std::find(mesh_formats.begin(), mesh_formats.end(), format) != mesh_formats.end())
        return mesh_reader(format, folder);
    if (std::find(point_formats.begin(), point_formats.end(), format) != point_formats.end())
        return point_reader(format, format.substr(format.find('_') + 1), folder);
    for (const FieldFormat& field : field_formats)
        if (field.format == format) return field_reader(format, field.ending, field.damaged, folder);
    std::string known;
    for (const std::string& name : formats()) known += ' ' + name;
    fail("no reader is named '" + format + "'; there are" + known);
}

std::vector<std::string> sound_and_kept(const Reader& reader) {
    std::vector<std::string> inputs = reader.seeds;
    const fs::path kept = fs::path(CLSDF_FUZZ_CORPUS) / reader.format;
    if (!fs::exists(kept)) return inputs;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(kept)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        inputs.push_back(file.extension() == ".hex" ? spelt(content_of(file)) : content_of(file));
    return inputs;
}

}  // namespace clsdf::fuzz
