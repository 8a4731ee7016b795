#include "io/meshes/point_arrays.hpp"

#include "core/files.hpp"
#include "io/meshes/npy_header.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

namespace clsdf {

namespace {

/// The member `name` of each structure, which has so many numbers.
template <std::size_t width>
std::vector<std::array<double, width>> read_npy_member(InputFile& file, const NpyHeader& header,
                                                       const std::string& name) {
    const auto member = std::ranges::find(header.members, name, &NpyMember::name);
    if (member == header.members.end() || member->components != width) {
        std::vector<std::string> others;
        for (const NpyMember& other : header.members)
            others.push_back(fmt::format("'{}' of {}", other.name, other.components));
        file.fail(fmt::format("its structures have no member '{}' of {} number{}, but {}", name, width,
                              width == 1 ? "" : "s", fmt::join(others, ", ")));
    }
    if (header.shape.size() != 1 || header.shape[0] < 0)
        file.fail(fmt::format("header field 'shape': ({}); structures at points have the shape (n,)",
                              fmt::join(header.shape, ", ")));
    const std::size_t bytes_of_structure = header.structure_bytes;
    const std::array sizes{header.shape[0], static_cast<std::int64_t>(bytes_of_structure)};
    std::vector<std::byte> bytes(header.shape[0] == 0 ? 0 : checked_count(file, header.values, sizes));
    if (!bytes.empty()) read_values(file, header.values, ElementType::uint8, bytes);
    std::vector<std::array<double, width>> rows(bytes.size() / bytes_of_structure);
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t c = 0; c < width; ++c)
            with_number(member->type,
                        bytes.data() + i * bytes_of_structure + member->offset + c * bytes_of(member->type),
                        member->order, [&](auto number) { rows[i][c] = static_cast<double>(number); });
    return rows;
}

}  // namespace

template <std::size_t width>
std::vector<std::array<double, width>> read_npy_rows(const std::string& path, const char* what,
                                                     const std::string& member) {
    using Row = std::array<double, width>;
    InputFile file(path);
    refuse_other_content(FileContent(path, telling_bytes));
    const NpyHeader header = read_npy_header(file, !member.empty());
    if (!header.members.empty()) return read_npy_member<width>(file, header, member);
    if (is_whole(header.values.type))
        file.fail(fmt::format("header field 'descr': '{}' is not a coordinate; save them as float64 ('<f8')",
                              npy_name_of(header.values.type)));
    if (header.shape.size() != 2 || header.shape[0] < 0 || header.shape[1] != static_cast<std::int64_t>(width))
        file.fail(fmt::format("header field 'shape': ({}); {}", fmt::join(header.shape, ", "), what));
    if (header.shape[0] == 0) return {};
    const std::size_t count = checked_count(file, header.values, header.shape);
    std::vector<Row> points(count / width);
    const bool is_double = header.values.type == ElementType::float64;
    if (is_double && !header.fortran_order) {
        read_values(file, header.values, ElementType::float64, std::as_writable_bytes(std::span(points)));
        return points;
    }
    const auto read = [&]<typename Number>(std::vector<Number> numbers) {
        read_values(file, header.values, header.values.type, std::as_writable_bytes(std::span(numbers)));
        for (std::size_t i = 0; i < count; ++i) {
            const auto number = static_cast<double>(numbers[i]);
            if (header.fortran_order)
                points[i % points.size()][i / points.size()] = number;
            else
                points[i / width][i % width] = number;
        }
    };
    if (is_double)
        read(std::vector<double>(count));
    else
        read(std::vector<float>(count));
    return points;
}

template std::vector<std::array<double, 3>> read_npy_rows<3>(const std::string&, const char*, const std::string&);
template std::vector<std::array<double, 6>> read_npy_rows<6>(const std::string&, const char*, const std::string&);

std::vector<double> read_npy_numbers(const std::string& path, const std::string& member) {
    InputFile file(path);
    refuse_other_content(FileContent(path, telling_bytes));
    const NpyHeader header = read_npy_header(file, true);
    if (!header.members.empty()) {
        std::vector<double> numbers;
        for (const auto& [number] : read_npy_member<1>(file, header, member)) numbers.push_back(number);
        return numbers;
    }
    const bool is_column = header.shape.size() == 2 && header.shape[1] == 1;
    if ((header.shape.size() != 1 && !is_column) || header.shape[0] < 0)
        file.fail(fmt::format("header field 'shape': ({}); numbers at points have the shape (n,)",
                              fmt::join(header.shape, ", ")));
    if (header.shape[0] == 0) return {};
    const std::size_t count = checked_count(file, header.values, header.shape);
    const auto read = [&]<typename Number>(std::vector<Number> numbers) {
        read_values(file, header.values, header.values.type, std::as_writable_bytes(std::span(numbers)));
        return std::vector<double>(numbers.begin(), numbers.end());
    };
    switch (header.values.type) {
        case ElementType::float32:
            return read(std::vector<float>(count));
        case ElementType::float64:
            return read(std::vector<double>(count));
        case ElementType::uint32:
            return read(std::vector<std::uint32_t>(count));
        case ElementType::uint8:
            return read(std::vector<std::uint8_t>(count));
        default:
            return read(std::vector<std::int64_t>(count));
    }
}

}  // namespace clsdf
